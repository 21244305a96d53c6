#pragma once

#include <cstdint>

#include "common/voxel/material.hpp"

namespace terravox::gkot {

/// The numeric Minecraft block for a material: 0x00000DBB, BB = block id, D = data nibble; 0 for
/// air.
///
/// The mapping of the first system is kept: ground is dirt, low vegetation grass, medium vegetation
/// spruce leaves, high vegetation oak leaves, buildings and concrete light grey wool, roofs orange,
/// light grey or white wool, asphalt stone, water still water. Materials that it did not have are
/// mapped to the most similar block that can be distinguished.
[[nodiscard]] std::uint32_t block_word(voxel::Material material) noexcept;

}  // namespace terravox::gkot
