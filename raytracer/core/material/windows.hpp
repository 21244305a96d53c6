#pragma once

#include <cstdint>
#include <vector>

#include "raytracer/core/material/appearance.hpp"
#include "raytracer/core/material/texture_pool.hpp"

namespace terravox::material {

/// Windows on the walls of houses: floors of about 3 m, a window about every 3 m, each in a square
/// of whole voxels (of 1.7 m in a larger voxel), placed by height above the world's zero and by
/// position along the wall. What cannot be known from a voxel (where a house ends, where its floors
/// are) is derived from its position: the style of the windows is chosen by cells of about 12 m.
/// Immutable.
class Windows {
public:
    /// A point on a side face: voxel coordinates along the wall, upwards, and into it.
    struct At {
        std::int32_t along = 0;
        std::int32_t up = 0;
        std::int32_t into = 0;
        float s = 0, t = 0;    ///< [0, 1), along and up
        bool along_x = false;  ///< north and south faces
    };
    Windows();
    /// Draws over `out`: sets own, own_share, gloss, emission.
    void draw(const At& at, const FacePoint& point, Texel& out) const noexcept;

    static constexpr int kStyles = 8;
    struct Pane {
        voxel::Colour own;  ///< linear
        float share = 0;    ///< covered share of the wall
        float glass = 0;    ///< share that is glass: a part of `share`
    };
    [[nodiscard]] const Pane& pane(int style, int mip, int s, int t) const noexcept;

private:
    struct Grid {
        /// Voxels from window to window, from floor to floor, and along a window's square.
        int across = 3;
        int floor = 3;
        int edge = 1;
        double per_across = 0, per_floor = 0;  ///< reciprocals
        float fills = 1;                       ///< edge of the drawing as a share of the square's
    };
    [[nodiscard]] static Grid make_grid(double voxel_m) noexcept;
    /// @param lit set when the window is lit at night
    [[nodiscard]] Pane found_at(const At& at, const Grid& grid, float texels,
                                float& lit) const noexcept;
    std::vector<Pane> m_panes;  ///< by style, mip and texel
    Pane m_mean;                ///< over the styles
};

}  // namespace terravox::material
