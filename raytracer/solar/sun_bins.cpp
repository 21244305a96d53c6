#include "raytracer/solar/sun_bins.hpp"

#include <cmath>

namespace terravox::solar {

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
