#pragma once

#include <array>

#include "common/voxel/world.hpp"
#include "raytracer/core/base/ray.hpp"

namespace terravox::scene {
class Camera;
}  // namespace terravox::scene

namespace terravox::walk {

/// Which level of boxes represents which part of the world: a quadtree cut over the columns of
/// boxes, the same for every ray of a picture, so that shadows match the visible surface.
///
/// A column of level n is used where all of it is so far from the eye that a voxel of it covers at
/// most `detail` pixels; the coarsest such level is taken. Neighbours of different levels meet at
/// faces of boxes, so a ray crosses over without a seam. Immutable and a pure function of its
/// arguments: every processor of a picture has the same cut.
///
/// Voxels stick out of the world by up to their own size, and the space of all levels in use is
/// searched for them. So a level that no column is far enough for is not in use, even if allowed.
class LevelCut {
public:
    /// One level everywhere.
    /// @param bounds of the world, level-0 voxels
    LevelCut(const voxel::VoxelBounds& bounds, int level);
    /// @param eye level-0 voxels
    /// @param pixel_rad angle covered by the pixel in the middle of the picture
    /// @param detail pixels that a voxel may cover; 0: `finest` everywhere
    /// @param finest, coarsest levels that may be used
    LevelCut(const voxel::VoxelBounds& bounds, core::Vec3 eye, double pixel_rad, double detail,
             int finest, int coarsest);

    /// For any camera. Parallel rays see all of the world at one scale, so there is one level
    /// everywhere: the coarsest of which a voxel covers at most `detail` pixels.
    LevelCut(const voxel::VoxelBounds& bounds, const scene::Camera& camera, double detail,
             int finest, int coarsest);

    /// The level at a level-0 column.
    /// @param hint level at which the search begins; every hint gives the same answer
    [[nodiscard]] int level_at(std::int32_t x, std::int32_t z, int hint) const noexcept {
        int level = hint < m_finest ? m_finest : hint > m_coarsest ? m_coarsest : hint;
        while (level < m_coarsest &&
               far_enough(level + 1, x >> (kSideBits + level + 1), z >> (kSideBits + level + 1)))
            ++level;
        while (level > m_finest &&
               !far_enough(level, x >> (kSideBits + level), z >> (kSideBits + level)))
            --level;
        return level;
    }
    /// Whether the column (bx, bz) of a level is far enough for that level; if so, its halves are
    /// far enough for theirs.
    [[nodiscard]] bool far_enough(int level, std::int32_t bx, std::int32_t bz) const noexcept {
        if (level <= m_finest)
            return true;
        if (level > m_coarsest)
            return false;
        const double side = static_cast<double>(std::int64_t{1} << (kSideBits + level));
        const double dx = outside(m_eye.x, bx * side, (bx + 1.0) * side);
        const double dz = outside(m_eye.z, bz * side, (bz + 1.0) * side);
        return dx * dx + m_dy * m_dy + dz * dz >= m_near2[static_cast<std::size_t>(level)];
    }
    [[nodiscard]] int finest() const noexcept { return m_finest; }
    /// The coarsest level in use: no column within the bounds is far enough for another.
    [[nodiscard]] int coarsest() const noexcept { return m_coarsest; }
    [[nodiscard]] core::Vec3 eye() const noexcept { return m_eye; }
    /// Of the world, level-0 voxels.
    [[nodiscard]] const voxel::VoxelBounds& bounds() const noexcept { return m_bounds; }
    /// entry_bounds() in voxels of a level that may be used.
    [[nodiscard]] const voxel::VoxelBounds& bounds(int level) const noexcept {
        return m_level_bounds[static_cast<std::size_t>(level)];
    }

    /// Bounds at which rays enter the world: level-0 voxels, rounded outwards so far that no voxel
    /// of any level sticks out.
    [[nodiscard]] const voxel::VoxelBounds& entry_bounds() const noexcept { return m_entry_bounds; }

    static constexpr int kSideBits = 6;  ///< log2 of the side of a box in voxels

private:
    [[nodiscard]] static double outside(double v, double low, double high) noexcept {
        return v < low ? low - v : v > high ? v - high : 0;
    }
    voxel::VoxelBounds m_bounds;
    voxel::VoxelBounds m_entry_bounds;
    std::array<voxel::VoxelBounds, voxel::kMaxLevel + 1> m_level_bounds{};
    /// Square of the distance from which on a level is fine enough.
    std::array<double, voxel::kMaxLevel + 1> m_near2{};
    core::Vec3 m_eye;
    double m_dy = 0;  ///< vertical distance from the eye to the world's range of heights
    int m_finest;
    int m_coarsest;
};

/// The part of a world without end that a picture can show. Beyond it all of the world, from its
/// deepest ground to its summits and to the eye, covers less than a pixel above or below the
/// horizon, and rays meet the plain of the sky there, which has the light of the world.
/// @return all of the bounds for parallel rays, which have no horizon, and where the eye is so far
/// off that no part of the world is near
[[nodiscard]] voxel::VoxelBounds within_horizon(const voxel::VoxelBounds& bounds,
                                                const scene::Camera& camera) noexcept;

}  // namespace terravox::walk
