#pragma once

#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <cstddef>
#include <thread>

#include "common/thread/tsan_order.hpp"

namespace terravox::thread {

/// @param requested requested number of threads; 0 = one per core
/// @return at least 1
[[nodiscard]] inline int thread_count(int requested) noexcept {
    if (requested > 0)
        return requested;
    const unsigned cores = std::thread::hardware_concurrency();
    return cores == 0 ? 1 : static_cast<int>(cores);
}

/// Calls work(i) for each i in [0, count), on at most `threads` threads (0 = one per core) and no
/// more than there are cores, in unspecified order.
/// @throws what the first failing call threw, after the others have ended
template <class Work>
void parallel_for(std::size_t count, int threads, const Work& work) {
    // Asked for more, TBB has no more, but writes a warning to standard error.
    oneapi::tbb::task_arena arena(std::min(thread_count(threads), thread_count(0)));
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
