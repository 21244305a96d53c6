#pragma once

#include <memory>
#include <vector>

#include "common/voxel/box.hpp"
#include "common/voxel/material.hpp"
#include "voxelserver/voxelize/runs.hpp"

namespace terravox::voxelize {

/// The true colours of a patch from above, index = z * 64 + x; `valid` is empty where there is no orthophoto at all.
struct PatchColours {
    std::vector<voxel::Rgb8> colour;
    std::vector<std::uint8_t> valid;
};

/// Step "serialization": cuts one box out of the columns of its patch.
/// @param colours seen from above: they replace the points' own colours for everything but walls and water
/// @return nullptr when the box is air
[[nodiscard]] std::shared_ptr<const voxel::Box> serialize(const voxel::BoxKey& key, const PatchRuns& runs, const PatchColours& colours);

}  // namespace terravox::voxelize
