#pragma once

#include <vector>

#include "voxelserver/tools/survey/plane.hpp"
#include "voxelserver/tools/survey/terrain.hpp"

namespace terravox::survey {

/// A lattice mast with one cross-arm.
struct Pylon {
    Vec2 at;
    Vec2 along{1, 0};  ///< of length 1, direction of the line
    double ground_m = 0;
    double top_m = 0;
    /// @return half the width of the mast at a height, metres
    [[nodiscard]] double half_width_m(double height_m) const noexcept;
    /// Whether a point lies within the outline of mast or arm.
    [[nodiscard]] bool holds(Vec2 p, double height_m) const noexcept;
};

/// A conductor between two masts: a parabola.
struct Wire {
    Vec2 a;
    Vec2 b;
    double a_m = 0, b_m = 0;  ///< heights of the ends
    double sag_m = 0;
    [[nodiscard]] double height_m(double along) const noexcept {
        return lerp(a_m, b_m, along) - 4.0 * sag_m * along * (1.0 - along);
    }
};

struct PowerLine {
    std::vector<Pylon> pylons;
    std::vector<Wire> wires;
};
inline constexpr double kPylonSpan_m = 170;
inline constexpr double kPylonArm_m = 4.2;  ///< half the width of the cross-arm
inline constexpr double kPylonHeight_m = 25;

/// The power lines that may reach into `area`: one along each river, on its south side.
[[nodiscard]] PowerLine build_power_line(const Terrain& terrain, const Box2& area);

}  // namespace terravox::survey
