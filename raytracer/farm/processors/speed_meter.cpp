#include "raytracer/farm/processors/speed_meter.hpp"

#include <cmath>
#include <utility>

namespace terravox::processors {
namespace {

using Seconds = std::chrono::duration<double>;

/// Half-life of the counted pixels and seconds.
constexpr double kHalfLife_s = 4;

}  // namespace

void SpeedMeter::start(Time now) noexcept {
    if (!std::exchange(m_is_busy, true))
        m_counted_until = now;
}

void SpeedMeter::advance(Time now) noexcept {
    if (!m_is_busy)
        return;
    const double passed_s = Seconds(now - m_counted_until).count();
    const double keep = std::exp2(-passed_s / kHalfLife_s);
    m_recent_pixels *= keep;
    m_recent_s = m_recent_s * keep + passed_s;
    m_busy_s += passed_s;
    m_counted_until = now;
}

void SpeedMeter::stop(Time now) noexcept {
    advance(now);
    m_is_busy = false;
}

void SpeedMeter::add_answer(std::size_t pixels) noexcept {
    if (std::exchange(m_is_warming_up, false))
        m_recent_s = 0;
    else
        m_recent_pixels += static_cast<double>(pixels);
}

double SpeedMeter::pixels_per_s() const noexcept {
    return m_recent_s > 0 ? m_recent_pixels / m_recent_s : 0;
}

double SpeedMeter::busy_s(Time now) const noexcept {
    return m_busy_s + (m_is_busy ? Seconds(now - m_counted_until).count() : 0);
}

}  // namespace terravox::processors
