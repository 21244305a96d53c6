#pragma once

#include <vector>

#include "voxelserver/sunlight/scene.hpp"

namespace terravox::sunlight {

/// A direction towards the sun.
struct Sun {
    double azimuth_deg = 180;  ///< clockwise from grid north, [0, 360)
    double altitude_deg = 45;  ///< above the horizon, (0, 90)
};

/// The slope (rise over run) to the highest that stands between each cell and the horizon towards
/// an azimuth, at most `margin` cells away. 0 for cells of the margin.
[[nodiscard]] std::vector<float> horizons(const Scene& scene, double azimuth_deg);

/// The share of the sun that a cell with this horizon sees, [0, 1]: it rises over about two degrees
/// of altitude, as heights are not exact.
class Sunlit {
public:
    explicit Sunlit(double altitude_deg) noexcept;
    [[nodiscard]] float share(float horizon) const noexcept {
        const float value = 0.5F + (m_rise - horizon) * m_sharpness;
        return value < 0 ? 0.0F : (value > 1 ? 1.0F : value);
    }

private:
    float m_rise;
    float m_sharpness;
};

/// How much sunlight falls on a slope, over that on flat ground; 0 on the far side.
class Facing {
public:
    explicit Facing(const Sun& sun) noexcept;
    [[nodiscard]] float on(const Slope& slope) const noexcept;

private:
    float m_east;  ///< of the direction towards the sun over its rise
    float m_south;
};

}  // namespace terravox::sunlight
