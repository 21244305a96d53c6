#pragma once

#include <cstddef>
#include <utility>

#include "common/geo/lat_lon.hpp"
#include "common/util/det_math.hpp"
#include "raytracer/core/base/ray.hpp"

namespace terravox::solar {

/// Directions of an analysis: rays of a cell are bounded, whatever a scene asks for.
inline constexpr std::size_t kMaxDirections = 65'536;
/// @throws UsageError for more than kMaxDirections
void check_directions(std::size_t count);

/// Bins of equal angles by hour angle and declination, as seen from a latitude: the sun's way
/// through the sky is a strip of these coordinates at every latitude.
class SunBins {
public:
    static constexpr double kSmallest_deg = 0.1;

    /// @param bin_deg at least kSmallest_deg
    /// @throws UsageError for smaller bins
    SunBins(const geo::MapPlace& place, double bin_deg);

    /// Numbers of a bin; they order bins from the east to the west.
    using Place = std::pair<int, int>;
    /// @param to of unit length; x to the map's east, y up, z to its south
    [[nodiscard]] Place place_of(core::Vec3 to) const noexcept;

private:
    det::SinCos m_latitude;
    det::SinCos m_convergence;
    double m_bin_deg;
};

}  // namespace terravox::solar
