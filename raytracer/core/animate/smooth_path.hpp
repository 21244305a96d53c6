#pragma once

#include <vector>

namespace terravox::animate {

/// A number that moves smoothly through given ones: piecewise cubic with a continuous first
/// derivative. Constant before the first and after the last. Immutable.
class SmoothPath {
public:
    enum class Kind : bool {
        kRound,     ///< for positions: round bends, which may overshoot
        kMonotone,  ///< never beyond the two neighbouring numbers
    };
    /// @param times ascending, seconds
    /// @param values as many as `times`, at least one
    /// @param at_rest whether the rate is 0 at both ends; otherwise it is that of the first and
    /// last segment
    SmoothPath(std::vector<double> times, std::vector<double> values, Kind kind, bool at_rest);
    [[nodiscard]] double at(double time) const noexcept;

private:
    std::vector<double> m_times;
    std::vector<double> m_values;
    std::vector<double> m_rates;
};

}  // namespace terravox::animate
