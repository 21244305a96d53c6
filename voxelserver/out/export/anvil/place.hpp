#pragma once

#include <array>
#include <cstdint>

#include "voxelserver/out/export/core/job.hpp"

namespace terravox::exports::anvil {

inline constexpr int kSectionSize = 16;  ///< edge of a section, blocks; chunks are as wide
inline constexpr int kRegionSize = 512;  ///< blocks of a region file along x and z

/// The place of a part of a world in a Minecraft world.
struct Place {
    /// Voxel of the part minus offset = block. Multiples of 512 in x and z, of 16 in y.
    std::array<std::int32_t, 3> offset{};
    std::int32_t min_y = -64, height = 384;  ///< of the dimension, blocks; multiples of 16
    /// Whether the heights require a data pack.
    [[nodiscard]] bool needs_pack() const noexcept { return min_y != -64 || height != 384; }
    [[nodiscard]] std::int32_t first_section() const noexcept { return min_y / kSectionSize; }
    [[nodiscard]] std::int32_t sections() const noexcept { return height / kSectionSize; }
};

/// Places the centre of the part near x = z = 0. Heights stay as they are where they fit, else they
/// are shifted; the dimension is the usual -64 to 319 where that suffices.
/// @throws UsageError when no Minecraft world is high or wide enough, naming the level that would
/// fit
[[nodiscard]] Place place_of(const Part& part);

}  // namespace terravox::exports::anvil
