#pragma once

#include <cstdint>

#include "common/voxel/material.hpp"

namespace terravox::gkot {

/// What a material is among Minecraft's numeric blocks: 0x00000DBB, BB = block id, D = data nibble;
/// 0 for air.
///
/// The first system's own are kept: ground is dirt, low vegetation grass, medium vegetation spruce
/// leaves, high vegetation oak leaves, buildings and concrete light grey wool, roofs orange, light
/// grey or white wool, asphalt stone, water still water. What it did not know is what comes nearest
/// and can be told apart.
[[nodiscard]] std::uint32_t block_word(voxel::Material material) noexcept;

}  // namespace terravox::gkot
