#pragma once

#include <oneapi/tbb/info.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <cstddef>

#include "common/thread/tsan_order.hpp"

namespace terravox::thread {

/// @param requested requested number of threads; 0 = one for each core that the process may use
///     (`taskset` and containers leave it fewer than the machine has)
/// @return at least 1
[[nodiscard]] inline int thread_count(int requested) noexcept {
    return requested > 0 ? requested : std::max(oneapi::tbb::info::default_concurrency(), 1);
}

/// @return how many of the requested threads TBB can give: asked for more than thread_count(0), it
///     has no more, but writes a warning to standard error
[[nodiscard]] inline int task_thread_count(int requested) noexcept {
    return std::min(thread_count(requested), thread_count(0));
}

/// Calls work(i) for each i in [0, count), on at most `threads` threads (0 = one per core) and no
/// more than there are cores, in unspecified order.
/// @throws what the first failing call threw, after the others have ended
template <class Work>
void parallel_for(std::size_t count, int threads, const Work& work) {
    oneapi::tbb::task_arena arena(task_thread_count(threads));
    TsanTasks tasks;
    const auto one = [&](std::size_t i) {
        const TsanTasks::Task task(tasks);
        work(i);
    };
    arena.execute([&] {
        oneapi::tbb::parallel_for(std::size_t{0}, count, one, oneapi::tbb::simple_partitioner{});
    });
}

}  // namespace terravox::thread
