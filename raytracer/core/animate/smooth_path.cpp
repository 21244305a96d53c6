#include "raytracer/core/animate/smooth_path.hpp"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace terravox::animate {
namespace {

// Of the parabola through three neighbours: Catmull and Rom's choice where times are even.
// Ref: Catmull & Rom, "A Class of Local Interpolating Splines", 1974.
double round_rate(double h0, double h1, double slope0, double slope1) noexcept {
    return (slope0 * h1 + slope1 * h0) / (h0 + h1);
}

// A weighted harmonic mean, or a stop at a summit.
// Ref: Fritsch & Butland, "A Method for Constructing Local Monotone Piecewise Cubic Interpolants",
// 1984.
double monotone_rate(double h0, double h1, double slope0, double slope1) noexcept {
    if (!(slope0 * slope1 > 0))
        return 0;
    const double w0 = 2 * h1 + h0;
    const double w1 = h1 + 2 * h0;
    return (w0 + w1) / (w0 / slope0 + w1 / slope1);
}

}  // namespace

SmoothPath::SmoothPath(std::vector<double> times, std::vector<double> values, Kind kind,
                       bool at_rest)
    : m_times(std::move(times)), m_values(std::move(values)), m_rates(m_times.size(), 0.0) {
    const std::size_t n = m_times.size();
    const auto width = [&](std::size_t i) { return m_times[i + 1] - m_times[i]; };
    const auto slope = [&](std::size_t i) { return (m_values[i + 1] - m_values[i]) / width(i); };
    for (std::size_t i = 1; i + 1 < n; ++i)
        m_rates[i] = (kind == Kind::kRound ? round_rate : monotone_rate)(width(i - 1), width(i),
                                                                         slope(i - 1), slope(i));
    if (n > 1 && !at_rest) {
        m_rates.front() = slope(0);
        m_rates.back() = slope(n - 2);
    }
}

double SmoothPath::at(double time) const noexcept {
    if (!(time > m_times.front()))
        return m_values.front();
    if (time >= m_times.back())
        return m_values.back();
    const auto next = static_cast<std::size_t>(
        std::upper_bound(m_times.begin(), m_times.end(), time) - m_times.begin());
    const std::size_t i = next - 1;
    const double h = m_times[next] - m_times[i];
    const double s = (time - m_times[i]) / h;
    const double r = 1 - s;
    if (m_values[i] == m_values[next] && m_rates[i] == 0 && m_rates[next] == 0)
        return m_values[i];
    return m_values[i] * (r * r * (1 + 2 * s)) + m_values[next] * (s * s * (3 - 2 * s)) +
           h * (m_rates[i] * (s * r * r) - m_rates[next] * (s * s * r));
}

}  // namespace terravox::animate
