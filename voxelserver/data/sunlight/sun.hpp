#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "voxelserver/data/sunlight/scene.hpp"

namespace terravox::sunlight {

/// A direction towards the sun.
struct Sun {
    double azimuth_deg = 180;  ///< clockwise from grid north, [0, 360)
    double altitude_deg = 45;  ///< above the horizon, (0, 90)
};

/// The slope (rise over run) to the highest that stands between each cell and the horizon towards
/// an azimuth, at most `margin` cells away. 0 for cells of the margin.
[[nodiscard]] std::vector<float> horizons(const Surface& surface, double azimuth_deg);

/// The share of the sun that a cell with this horizon sees, [0, 1]: it rises over about two degrees
/// of altitude, as heights are not exact.
class Sunlit {
public:
    explicit Sunlit(double altitude_deg) noexcept;
    [[nodiscard]] float share(float horizon) const noexcept {
        return std::min(std::max(0.5F + (m_rise - horizon) * m_sharpness, 0.0F), 1.0F);
    }

private:
    float m_rise;
    float m_sharpness;
};

/// The share of the sun that each cell of a scene sees, [0, 1].
[[nodiscard]] std::vector<float> lit_shares(const Surface& surface, const Sun& sun);

/// How much sunlight falls on a slope, over that on flat ground; 0 on the far side.
class Facing {
public:
    explicit Facing(const Sun& sun) noexcept;
    /// @param up of the slope's normal: Slope::up()
    [[nodiscard]] float on(float east, float south, float up) const noexcept {
        return std::max(0.0F, up * (1 - m_east * east - m_south * south));
    }
    [[nodiscard]] float on(const Slope& slope) const noexcept {
        return on(slope.east, slope.south, slope.up());
    }

private:
    float m_east;  ///< of the direction towards the sun over its rise
    float m_south;
};

/// How the sun and the sky light the inner cells of a surface; index as in inner_cells() of it.
struct SurfaceLight {
    /// Share of the sun that is seen, as by Sunlit: [0, 1]. 1 where no height is known.
    std::vector<float> lit;
    std::vector<std::uint8_t> edge;  ///< 1 = near the edge of a shadow, where `lit` is not certain
    std::vector<float> facing;    ///< sunlight on its slope over that on flat ground, [0.15, 2.5]
    std::vector<float> sky_seen;  ///< share of the sky above its slope, (0.5, 1]
};

/// @param surface without gaps (fill_gaps)
/// @return `edge` is valid for cells at least kSurfaceEdge from the margin
[[nodiscard]] SurfaceLight surface_light(const Surface& surface, const Sun& sun);
inline constexpr int kSurfaceEdge = 3;

/// The sun that explains a photograph best.
struct SunEstimate {
    Sun sun;
    /// Correlation of the logarithm of the photograph's brightness with that of the light which the
    /// surface would receive, both relative to their means in tiles of 12 m and one kind: [-1, 1].
    double correlation = 0;
    /// By how much the correlation exceeds that of the best sun elsewhere (25 degrees away or
    /// more), over the correlation: [0, 1].
    double margin = 0;
};

/// Searches all azimuths, and altitudes from 12 to 75 degrees, coarse to fine. The result depends
/// on the scenes and their order only. Takes about 10 microseconds a cell.
/// @param scenes parts of one photograph, without gaps (fill_gaps)
/// @return nullopt where fewer than 500 cells can be compared
[[nodiscard]] std::optional<SunEstimate> find_sun(std::span<const Scene> scenes);

/// Whether an estimate is good enough to take shadows away by it. False estimates in surveys
/// without shadows reach a correlation of 0.1.
[[nodiscard]] bool is_certain(const SunEstimate& estimate) noexcept;

}  // namespace terravox::sunlight
