#pragma once

#include <vector>

namespace terravox::animate {

/// A number that moves smoothly through given ones: piecewise cubic, its rate of change is
/// continuous. Before the first and after the last it stands still. Immutable.
class SmoothPath {
public:
    enum class Kind : bool {
        kRound,     ///< through places: round bends, which may swing beyond
        kMonotone,  ///< never beyond the two numbers around
    };
    /// @param times rising, seconds @param values as many, at least one
    /// @param at_rest the rate is 0 at both ends; otherwise that of the first and last stretch
    SmoothPath(std::vector<double> times, std::vector<double> values, Kind kind, bool at_rest);
    [[nodiscard]] double at(double time) const noexcept;

private:
    std::vector<double> m_times, m_values, m_rates;
};

}  // namespace terravox::animate
