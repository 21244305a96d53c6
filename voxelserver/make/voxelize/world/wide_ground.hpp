#pragma once

#include <array>
#include <cstddef>

#include "common/util/cache.hpp"
#include "voxelserver/make/voxelize/columns/point_set.hpp"
#include "voxelserver/make/voxelize/steps/scattered.hpp"

namespace terravox::voxelize {

/// The ground in the middle of wide gaps (halls, quarries without returns, data without a ground
/// class): interpolated from the means of water cells up to some hundred voxels away. Computed for
/// a patch at its first query. Thread-safe.
class WideGround {
public:
    /// Rings of patches around a patch that are read, one after the other, until they hold enough
    /// water cells with ground.
    static constexpr std::array kRings{1, 2, 4, 8};
    static constexpr std::size_t kEnough = 16;  ///< for an interpolation from several sides

    WideGround(PointSet& points, std::size_t memory_bytes)
        : m_points(points), m_around(memory_bytes) {}

    /// @param x, z absolute voxels
    /// @param reach grows by the patches that were read
    /// @return height in voxels; where there is no ground for half a kilometre, the lowest returns
    /// around; NaN where there are none
    [[nodiscard]] float at(std::int32_t x, std::int32_t z, voxel::InputExtent& reach);

private:
    struct Around;
    [[nodiscard]] std::shared_ptr<const Around> make(grid::PatchKey patch);
    [[nodiscard]] float lowest_near(grid::PatchKey patch);
    PointSet& m_points;
    util::Cache<grid::PatchKey, Around, grid::PatchKeyHash> m_around;
};

}  // namespace terravox::voxelize
