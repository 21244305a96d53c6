#pragma once

#include "voxelserver/voxelize/window.hpp"

namespace terravox::voxelize {

/// Step "building fill", first half: roofs without holes. A column without building points whose neighbours nearly all have a
/// roof gets the median of theirs; the wall below is filled down to the local ground when columns become runs.
[[nodiscard]] Margined<Surface> close_roofs(const Window& window);

}  // namespace terravox::voxelize
