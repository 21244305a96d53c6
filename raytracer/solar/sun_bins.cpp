#include "raytracer/solar/sun_bins.hpp"

#include <cmath>
#include <string>

#include "common/util/error.hpp"

namespace terravox::solar {

void check_directions(std::size_t count) {
    if (count > kMaxDirections)
        throw util::UsageError("place the sun: more than " + std::to_string(kMaxDirections) +
                               " directions; allowed: fewer days, longer steps, or a larger "
                               "analysis.bin_deg");
}

SunBins::SunBins(double latitude_deg, double bin_deg)
    : m_latitude(det::sin_cos(latitude_deg * det::kPi / 180)), m_bin_deg(bin_deg) {
    if (!(bin_deg >= kSmallest_deg))
        throw util::UsageError("place the sun: analysis.bin_deg = " + std::to_string(bin_deg) +
                               "; allowed: 0.1 to 15, or 0 for a ray for each position");
}

SunBins::Place SunBins::place_of(core::Vec3 to) const noexcept {
    constexpr double kRad = det::kPi / 180;
    // The pole is in the north, the equator's highest point in the south.
    const double pole = to.y * m_latitude.sin - to.z * m_latitude.cos;
    const double equator = to.y * m_latitude.cos + to.z * m_latitude.sin;
    const double declination_deg = det::asin(pole) / kRad;
    const double hour_angle_deg = det::atan2(-to.x, equator) / kRad;
    return {static_cast<int>(std::floor(hour_angle_deg / m_bin_deg)),
            static_cast<int>(std::floor(declination_deg / m_bin_deg))};
}

}  // namespace terravox::solar
