#include "raytracer/analyse/solar/sun_bins.hpp"

#include <cmath>
#include <string>

#include "common/util/error.hpp"

namespace terravox::solar {
namespace {

constexpr double kDegree = det::kPi / 180;  ///< radians

}  // namespace

void check_directions(std::size_t count) {
    if (count > kMaxDirections)
        throw util::UsageError("place the sun: more than " + std::to_string(kMaxDirections) +
                               " directions; allowed: fewer days, longer steps, or a larger "
                               "analysis.bin_deg");
}

SunBins::SunBins(const geo::MapPlace& place, double bin_deg)
    : m_latitude(det::sin_cos(place.lat_deg * kDegree)),
      m_convergence(det::sin_cos(place.convergence_deg * kDegree)),
      m_bin_deg(bin_deg) {
    if (!(bin_deg >= kSmallest_deg))
        throw util::UsageError("place the sun: analysis.bin_deg = " + std::to_string(bin_deg) +
                               "; allowed: 0.1 to 15, or 0 for a ray for each position");
}

SunBins::Place SunBins::place_of(core::Vec3 to) const noexcept {
    // Hour angle and declination are of true north: the map's turn is taken back.
    const double east = to.x * m_convergence.cos - to.z * m_convergence.sin;
    const double south = to.z * m_convergence.cos + to.x * m_convergence.sin;
    // The pole is in the north, the equator's highest point in the south.
    const double pole = to.y * m_latitude.sin - south * m_latitude.cos;
    const double equator = to.y * m_latitude.cos + south * m_latitude.sin;
    const double declination_deg = det::asin(pole) / kDegree;
    const double hour_angle_deg = det::atan2(-east, equator) / kDegree;
    return {static_cast<int>(std::floor(hour_angle_deg / m_bin_deg)),
            static_cast<int>(std::floor(declination_deg / m_bin_deg))};
}

}  // namespace terravox::solar
