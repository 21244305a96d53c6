#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "common/voxel/world.hpp"

namespace terravox::boxes {

/// The kind of a cached item.
enum class Kind : int { kBox = 0, kMapTile = 1 };

/// The bytes of an item, and the extent of its inputs.
struct Item {
    std::uint64_t tag = 0;                     ///< opaque to the cache: returned as it was given
    std::shared_ptr<const std::string> bytes;  ///< nullptr is a value, too: known to be empty
    voxel::InputExtent reach;
};

}  // namespace terravox::boxes
