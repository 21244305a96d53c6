#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "raytracer/core/base/ray.hpp"

namespace terravox::solar {

/// A top of the terrain outside of the data, as seen from a point within.
struct FarTop {
    std::int32_t distance_m = 0;
    /// Above the sea, lowered by what the Earth's curvature hides at this distance.
    std::int32_t height_m = 0;
};

/// Terrain outside of the data, as far as it can hide the sun and the sky: what is seen from a
/// lattice of points across the data, in each of 360 azimuths.
///
/// A line of tops hides what is below it. For a slope, each top has a *shadow height* at the point:
/// rays that begin lower meet the top, rays that begin higher pass over it. Shadow heights are
/// interpolated between points and azimuths; heights and slopes of rays are used as they are, so
/// that tops near the data may be in it, too. Immutable.
class FarHorizon {
public:
    static constexpr int kAzimuths = 360;  ///< evenly around, clockwise from the map's north
    static constexpr int kMaxAcross = 9;   ///< points from west to east, and from north to south
    static constexpr std::size_t kMaxTops = 16;  ///< of a point and azimuth
    static constexpr std::int32_t kMaxDistance_m = 1'000'000;
    static constexpr std::int32_t kLowest_m = -200'000;  ///< 400 km away the Earth hides 11 km
    static constexpr std::int32_t kHighest_m = 10'000;

    /// Where the points are: evenly between two corners, level-0 voxels; x east, z south.
    struct Lattice {
        int columns = 1;  ///< along x
        int rows = 1;     ///< along z
        double west = 0;
        double north = 0;
        double east = 0;
        double south = 0;

        [[nodiscard]] std::size_t points() const noexcept;
        [[nodiscard]] double x(int column) const noexcept;
        [[nodiscard]] double z(int row) const noexcept;
    };
    /// Of one point and azimuth: each farther away and higher than the one before. Those that no
    /// slope needs may be left out.
    using Tops = std::vector<FarTop>;

    /// Nothing is far away: nothing is hidden.
    FarHorizon() = default;
    /// @param tops kAzimuths for each point, row by row; up to kMaxTops each
    /// @param voxel_m edge of a level-0 voxel, metres
    FarHorizon(const Lattice& lattice, const std::vector<Tops>& tops, double voxel_m);

    [[nodiscard]] bool empty() const noexcept { return m_begins.empty(); }
    /// Whether the terrain hides a direction.
    /// @param from level-0 voxels, y up from the sea; outside of the lattice: as at
    /// its border
    /// @param to of unit length, to.y >= 0
    [[nodiscard]] bool hides(core::Vec3 from, core::Vec3 to) const noexcept;

private:
    [[nodiscard]] double shadow_height(std::size_t point, int azimuth, double slope) const noexcept;
    [[nodiscard]] double shadow_height(core::Vec3 from, double azimuth_deg,
                                       double slope) const noexcept;

    Lattice m_lattice;
    double m_voxel_m = 1;
    std::vector<std::uint32_t> m_begins;  ///< of each point and azimuth among m_tops, and the end
    std::vector<FarTop> m_tops;
    /// For slopes from i / kBoundsPerSlope on: no shadow is higher.
    std::vector<double> m_bounds;
};

/// A horizon as text: "columns,rows;west,north;east,south;" and the tops of each point and azimuth,
/// "distance,height,distance,height,...;". Some 200 kB for a square of LiDAR data.
[[nodiscard]] std::string to_text(const FarHorizon::Lattice& lattice,
                                  const std::vector<FarHorizon::Tops>& tops);

/// Reads such a text; an empty one is an empty horizon.
/// @param text from a scene, which may be anybody's
/// @throws UsageError for another text, and for numbers out of range
[[nodiscard]] FarHorizon parse_far_horizon(const std::string& text, double voxel_m);

}  // namespace terravox::solar
