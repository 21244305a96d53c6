#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "voxelserver/out/export/anvil/place.hpp"

namespace terravox::exports::anvil {

/// Name of the data pack that allows high worlds.
inline constexpr const char* kPackName = "terravox-height";

/// level.dat as NBT, uncompressed: a creative world that is empty around what was written, and
/// begins at noon at `spawn` (a block's coordinates).
[[nodiscard]] std::string level_dat(const std::string& title,
                                    const std::array<std::int32_t, 3>& spawn, const Place& place);

/// data/minecraft/dimension_type/overworld.json of the data pack, and its pack.mcmeta.
[[nodiscard]] std::string dimension_type(const Place& place);
[[nodiscard]] std::string pack_mcmeta();

}  // namespace terravox::exports::anvil
