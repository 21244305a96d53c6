#pragma once

#include <algorithm>
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

}  // namespace terravox::sunlight
