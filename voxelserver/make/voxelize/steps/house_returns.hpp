#pragma once

#include <algorithm>

#include "voxelserver/make/voxelize/columns/columns.hpp"
#include "voxelserver/make/voxelize/points/class_table.hpp"
#include "voxelserver/make/voxelize/points/settings.hpp"
#include "voxelserver/make/voxelize/steps/ground_fill.hpp"

namespace terravox::voxelize {

/// Which returns of plants and of unclassified points are of a house.
///
/// A return within a metre of a column that is built upon, and not higher than its roof, is of the
/// wall: a balcony, a frame of a window, scatter. Where voxels are wider than that, columns beside
/// a house are none of it: most of their returns are farther away. One of a class of plants is so
/// only where it is as high as a tree and no foliage lies on its side away from the house. An
/// unclassified return above a roof, closer to it than foliage to foliage of one crown, is of a
/// thing on the roof, unless foliage next to the house reaches over to it.
class HouseReturns {
public:
    /// All must outlive this.
    HouseReturns(const Window& window, const ClassTable& classes, const GroundHeights& ground,
                 const Settings::Vegetation& settings, double voxel_m);

    enum class Part { kNone, kWall, kOnRoof };
    /// @param x, z in [-GroundHeights::kMargin, 64 + GroundHeights::kMargin)
    [[nodiscard]] Part part(int x, int z, const ObjectVoxel& o) const;
    /// The lowest voxel of a column that no wall within a metre is as high as: below it nothing is
    /// guessed to grow. INT32_MIN: there is no wall.
    [[nodiscard]] std::int32_t clear_of_walls(int x, int z) const noexcept;

private:
    static constexpr int kMaxReach = 10;  ///< columns: a wall's returns in voxels of 0.1 m
    static constexpr int kMargin = GroundHeights::kMargin + 2 * kMaxReach;
    struct Near {
        float wall = kNoHeight;  ///< highest roof around the column, voxels
        float roof = kNoHeight;  ///< over the column itself, also where it closes a gap
        bool built = false;      ///< the column is built upon: that roof was seen
    };
    [[nodiscard]] bool plant_like(const ObjectVoxel& o) const noexcept;
    [[nodiscard]] bool of_wall(const Near& near, std::int32_t y) const noexcept;
    [[nodiscard]] bool foliage_beside(int x, int z, std::int32_t y, int far) const;
    /// How far foliage next to a house reaches over its roof, columns.
    [[nodiscard]] int far_around() const noexcept { return std::max(2 * m_reach, 1); }

    const Window& m_window;
    const ClassTable& m_classes;
    const GroundHeights& m_ground;
    int m_reach = 0;         ///< columns; 0: voxels are so coarse that no wall reaches over
    std::int32_t m_gap = 0;  ///< voxels, between foliage of one crown
    float m_tree = 0;        ///< voxels above the ground
    Grid<Near, kMargin> m_near{Near{}};
    bool m_any;
};

}  // namespace terravox::voxelize
