#pragma once

#include <cstddef>
#include <memory>

#include "common/util/cache.hpp"
#include "voxelserver/data/sunlight/light_removal.hpp"
#include "voxelserver/make/voxelize/columns/point_set.hpp"

namespace terravox::voxelize {

/// What is highest in each column, as a surface that casts shadows. Thread-safe.
class PhotoSurface {
public:
    /// Points must outlive this.
    explicit PhotoSurface(PointSet& points);

    /// Patches and a margin of patches around them, without gaps. In the patches and
    /// `kFilledTogether` cells around them, which are photographed, gaps are filled from all
    /// sides. Farther away, where the surface only casts shadows, small gaps are filled within
    /// each patch, once for all patches around, and wide ones cast no shadow.
    /// @param margin in patches, at least 1
    /// @throws Error naming a damaged file
    [[nodiscard]] sunlight::Surface around(const grid::PatchRect& patches, int margin);
    static constexpr int kFilledTogether = sunlight::kEdgeReach;

private:
    struct PatchTops {
        sunlight::Surface seen;   ///< with gaps
        sunlight::Surface casts;  ///< small gaps are filled, wide ones very low
    };
    using Part = sunlight::Surface PatchTops::*;
    [[nodiscard]] sunlight::Surface assembled(const grid::PatchRect& patches, int margin,
                                              Part part);
    [[nodiscard]] std::shared_ptr<const PatchTops> tops_of(grid::PatchKey key);
    [[nodiscard]] static PatchTops casting(sunlight::Surface seen);

    PointSet& m_points;
    double m_voxel_m;
    std::shared_ptr<const PatchTops> m_nothing;  ///< of a patch in which nothing was seen
    util::Cache<grid::PatchKey, PatchTops, grid::PatchKeyHash> m_tops;
};

}  // namespace terravox::voxelize
