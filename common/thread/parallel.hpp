#pragma once

#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>
#include <sched.h>

#include <algorithm>
#include <cstddef>
#include <thread>

#include "common/thread/tsan_order.hpp"
#include "common/util/process_memory.hpp"

namespace terravox::thread {

/// @return how many cores the calling thread may use, at least 1: `taskset` and the cpusets of
///     containers leave it fewer than the machine has, which std::thread does not know. A share of
///     their time (cgroup quotas, `docker --cpus`) is not looked at
[[nodiscard]] inline int usable_cores() noexcept {
    cpu_set_t cores;
    // Refused on machines with more than 1024 cores.
    if (::sched_getaffinity(0, sizeof cores, &cores) == 0)
        return std::max(CPU_COUNT(&cores), 1);
    return std::max(static_cast<int>(std::thread::hardware_concurrency()), 1);
}

/// @param requested requested number of threads; 0 = one for each core that the process may use
/// @return at least 1
[[nodiscard]] inline int thread_count(int requested) noexcept {
    return requested > 0 ? requested : usable_cores();
}

/// @return how many of the requested threads TBB can give: asked for more than there are cores, it
///     has no more, but writes a warning to standard error
[[nodiscard]] inline int task_thread_count(int requested) noexcept {
    return std::min(thread_count(requested), usable_cores());
}

/// To be called before each use of TBB. When the first thread that uses it lacks memory, oneTBB
/// 2022 spins for ever: what throws asks whether it may, under a lock that the thread already
/// holds.
/// @throws std::bad_alloc when the thread is new to TBB and memory is short
inline void check_memory_for_tasks() {
    constexpr std::size_t kHeadroom_bytes = std::size_t{8} << 20;  // some KiB for each core
    namespace tbb = oneapi::tbb;
    // While a thread that has used it lives, TBB keeps what it has made at first.
    if (tbb::this_task_arena::current_thread_index() == tbb::task_arena::not_initialized)
        util::check_memory(kHeadroom_bytes);
}

/// Calls work(i) for each i in [0, count), on at most `threads` threads (0 = one per core) and no
/// more than there are cores, in unspecified order.
/// @throws what the first failing call threw, after the others have ended; std::bad_alloc
template <class Work>
void parallel_for(std::size_t count, int threads, const Work& work) {
    check_memory_for_tasks();
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
