#pragma once

#include <time.h>

#include "tests/bench/bench.hpp"

namespace terravox::bench {

/// User and system time of all threads of this process so far, seconds.
[[nodiscard]] inline double process_cpu_s() noexcept {
    timespec now{};
    ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + static_cast<double>(now.tv_nsec) * 1e-9;
}

/// What some work took.
struct Cost {
    double wall_s = 0;
    double cpu_s = 0;
};
template <class Work>
[[nodiscard]] Cost measure_cost(const Work& work) {
    const double before = process_cpu_s();
    Cost out;
    out.wall_s = measure_seconds(work);
    out.cpu_s = process_cpu_s() - before;
    return out;
}

}  // namespace terravox::bench
