#include "voxelserver/tools/survey/scanner.hpp"

#include <utility>

namespace terravox::survey {
namespace {

// The direction of flight: 3-4-5 of a half turn would be too oblique; 5-60 of 60.21 gives 4.8
// degrees off the north.
constexpr double kTurn = 60.20797289396148;
constexpr Vec2 kForward{5.0 / kTurn, 60.0 / kTurn};
constexpr Vec2 kAcross{60.0 / kTurn, -5.0 / kTurn};
constexpr double kFirstTime_s = 3.6e8;  ///< adjusted standard GPS time of the first strip
constexpr double kStripTime_s = 20000;  ///< between the middles of two strips
constexpr double kJitter = 0.22;        ///< of the spacing, each way

// Degrees; the error is below 0.001 for the leans that occur (|lean| <= 0.28).
double to_angle(double lean) noexcept {
    const double s = lean * lean;
    return lean * (1.0 - s * (1.0 / 3.0 - s * (1.0 / 5.0 - s / 7.0))) * 57.29577951308232;
}

/// How far an area reaches along an axis, from the least to the greatest.
std::pair<double, double> measure_reach(const Box2& area, Vec2 axis) noexcept {
    return std::minmax({dot({area.x0, area.y0}, axis), dot({area.x1, area.y0}, axis),
                        dot({area.x0, area.y1}, axis), dot({area.x1, area.y1}, axis)});
}

}  // namespace

ScanPattern::ScanPattern(std::uint64_t seed, double density) : m_seed(compute_hash(seed, 0x5CA)) {
    const double strip_density = density * kStripDistance_m / kSwath_m;
    m_spacing_m = 1.0 / std::sqrt(strip_density);
    m_pulses_per_line = static_cast<std::int64_t>(kSwath_m / m_spacing_m);
}

Vec2 ScanPattern::place(double across_m, double forward_m) noexcept {
    return kAcross * across_m + kForward * forward_m;
}

ScanPattern::Span ScanPattern::strips_over(const Box2& area) const noexcept {
    const auto [low, high] = measure_reach(area, kAcross);
    return {static_cast<std::int64_t>(std::floor((low - 0.5 * kSwath_m) / kStripDistance_m)),
            static_cast<std::int64_t>(std::floor((high + 0.5 * kSwath_m) / kStripDistance_m)) + 1};
}

ScanPattern::Span ScanPattern::lines_over(const Box2& area) const noexcept {
    const auto [low, high] = measure_reach(area, kForward);
    // Lines wander by at most 8 spacings along the strip.
    return {static_cast<std::int64_t>(std::floor(low / m_spacing_m)) - 9,
            static_cast<std::int64_t>(std::floor(high / m_spacing_m)) + 9};
}

ScanPattern::Line ScanPattern::line(std::int64_t strip, std::int64_t number) const noexcept {
    // The aircraft's speed varies slowly: a triangle wave of 160 lines moves the lines by up to 8
    // spacings, so the density along the strip changes between 0.85 and 1.25 of its mean. Each
    // strip has its own phase.
    const auto phase = static_cast<std::int64_t>(compute_hash(m_seed, strip) % 160);
    const std::int64_t shifted = number + phase;
    const std::int64_t in_wave = ((shifted % 160) + 160) % 160;
    const double wave = in_wave < 80 ? static_cast<double>(in_wave) / 80.0
                                     : static_cast<double>(160 - in_wave) / 80.0;
    return {strip, number, (static_cast<double>(number) + 14.0 * (wave - 0.5)) * m_spacing_m};
}

ScanPattern::Span ScanPattern::clip(const Line& line, const Box2& area) const noexcept {
    // The line runs from place(-swath/2) to place(+swath/2) along kAcross; both parts of kAcross
    // differ from 0.
    const Vec2 middle = place(static_cast<double>(line.strip) * kStripDistance_m, line.forward_m);
    const double margin = m_spacing_m;
    const double x_low = (area.x0 - margin - middle.x) / kAcross.x;
    const double x_high = (area.x1 + margin - middle.x) / kAcross.x;
    const double y_low = (area.y1 + margin - middle.y) / kAcross.y;
    const double y_high = (area.y0 - margin - middle.y) / kAcross.y;
    const double low = std::max(x_low, y_low);
    const double high = std::min(x_high, y_high);
    const double half = 0.5 * kSwath_m;
    if (low > half || high < -half || low > high)
        return {};
    const auto first = static_cast<std::int64_t>(std::floor((low + half) / m_spacing_m));
    const auto last = static_cast<std::int64_t>(std::floor((high + half) / m_spacing_m)) + 1;
    return {std::max<std::int64_t>(0, first), std::min(m_pulses_per_line - 1, last)};
}

Pulse ScanPattern::pulse(const Line& line, std::int64_t number) const noexcept {
    Pulse pulse;
    pulse.key = compute_hash(m_seed, line.strip, line.number, number);
    Random random(pulse.key);
    const double across =
        (static_cast<double>(number) + 0.5 + kJitter * random.range(-1, 1)) * m_spacing_m -
        0.5 * kSwath_m;
    const double forward = line.forward_m + kJitter * random.range(-1, 1) * m_spacing_m;
    pulse.foot = place(static_cast<double>(line.strip) * kStripDistance_m + across, forward);
    pulse.lean = kAcross * (-across / kFlightHeight_m);
    const bool north = flown_north(line.strip);
    pulse.angle_deg = to_angle(across / kFlightHeight_m) * (north ? 1.0 : -1.0);
    pulse.strip = static_cast<std::uint16_t>(1 + ((line.strip % 65535) + 65535 + 20) % 65535);
    pulse.forward = (line.number & 1) == 0;
    pulse.strip_edge = number == 0 || number == m_pulses_per_line - 1;
    const double seconds = static_cast<double>(line.number) * m_spacing_m / kSpeed_m_s;
    const double within = static_cast<double>(number) / static_cast<double>(m_pulses_per_line) *
                          0.98 * m_spacing_m / kSpeed_m_s;
    pulse.time_s = kFirstTime_s + static_cast<double>(line.strip) * kStripTime_s +
                   (north ? seconds : -seconds) + within;
    return pulse;
}

}  // namespace terravox::survey
