#pragma once

#include <chrono>

#include "tests/bench/children.hpp"

namespace terravox::bench {

/// Above this a figure is called noisy: on two cores a tenth of the machine was not ours.
inline constexpr double kQuietCores = 0.2;

/// Finds out how much of the machine others took while something was measured: what all processors
/// did, less what this process and the programs it started did. The load average at the start
/// does not cover the time after it.
class NoiseMeter {
public:
    /// Starts now. @param children those whose CPU time is our own; outlives the meter
    explicit NoiseMeter(const ChildRunner& children);
    /// Mean number of cores that others kept busy since the start; negative when it is not known
    /// here.
    [[nodiscard]] double others_cores() const;

private:
    [[nodiscard]] double own_s() const;
    const ChildRunner& m_children;
    std::chrono::steady_clock::time_point m_start;
    double m_busy_s;
    double m_own_s;
};

}  // namespace terravox::bench
