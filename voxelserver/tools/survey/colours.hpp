#pragma once

#include "voxelserver/tools/survey/building.hpp"
#include "voxelserver/tools/survey/land_cover.hpp"
#include "voxelserver/tools/survey/vegetation.hpp"

namespace terravox::survey {

/// sRGB, each channel [0, 255], not yet rounded.
struct Colour {
    double r = 0;
    double g = 0;
    double b = 0;
    [[nodiscard]] constexpr Colour operator*(double f) const noexcept {
        return {r * f, g * f, b * f};
    }
    [[nodiscard]] constexpr Colour mixed(Colour other, double part) const noexcept {
        return {lerp(r, other.r, part), lerp(g, other.g, part), lerp(b, other.b, part)};
    }
};

/// Colours of surfaces and objects from above on a summer's day. Functions of seed and place only.
[[nodiscard]] Colour ground_colour(std::uint64_t seed, Cover cover, Vec2 p) noexcept;
/// @param depth_m of the water; shallow water shows its bed
[[nodiscard]] Colour water_colour(std::uint64_t seed, Vec2 p, double depth_m, bool lake) noexcept;
/// @param side the roof face: 0 to the left of the ridge, 1 to the right
[[nodiscard]] Colour roof_colour(const Building& building, int side) noexcept;
[[nodiscard]] Colour crown_colour(const Tree& tree) noexcept;

}  // namespace terravox::survey
