#pragma once

#include <array>
#include <cstdint>

#include "voxelserver/export/core/job.hpp"

namespace terravox::exports::anvil {

inline constexpr int kSectionSize = 16;  ///< edge of a section, blocks; chunks are as wide
inline constexpr int kRegionSize = 512;  ///< blocks of a region file along x and z

/// Where a part of a world lies in a world of Minecraft.
struct Place {
    /// Voxel of the part minus offset = block. Multiples of 512 in x and z, of 16 in y.
    std::array<std::int32_t, 3> offset{};
    std::int32_t min_y = -64, height = 384;  ///< of the dimension, blocks; multiples of 16
    [[nodiscard]] bool needs_pack() const noexcept {
        return min_y != -64 || height != 384;
    }  ///< only a data pack allows such heights
    [[nodiscard]] std::int32_t first_section() const noexcept { return min_y / kSectionSize; }
    [[nodiscard]] std::int32_t sections() const noexcept { return height / kSectionSize; }
};

/// The centre of the part near x = z = 0; heights as they are where that fits, else moved so that
/// they fit; in the usual -64 to 319 where that fits.
/// @throws UsageError when no world of Minecraft is high or wide enough, naming the level that
/// would fit
[[nodiscard]] Place place_of(const Part& part);

}  // namespace terravox::exports::anvil
