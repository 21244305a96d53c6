#pragma once

#include <memory>

#include "common/voxel/box.hpp"
#include "voxelserver/make/voxelize/steps/runs.hpp"
#include "voxelserver/make/voxelize/steps/surface.hpp"

namespace terravox::voxelize {

/// Step "serialization": cuts one box out of the columns of its patch.
/// @param appearance colours seen from above: they replace the points' own colours for everything
/// but walls, water and what is below
/// @return nullptr when the box is air
[[nodiscard]] std::shared_ptr<const voxel::Box> serialize(const voxel::BoxKey& key,
                                                          const PatchRuns& runs,
                                                          const SurfaceAppearance& appearance);

}  // namespace terravox::voxelize
