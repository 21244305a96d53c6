#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "common/voxel/box.hpp"

namespace terravox::voxel {

inline constexpr const char* kBoxMediaType = "application/vnd.terravox.box";

/// The box's blob as one zstd frame (docs/formats/box.md). The same box and level give the same
/// bytes on every machine.
[[nodiscard]] std::vector<std::byte> compress(const Box& box, int zstd_level = 1);

/// The inverse, for bytes from anywhere. @param origin names the box in messages
/// @throws Error for a damaged or foreign frame, or one that claims more than a box can hold
[[nodiscard]] std::shared_ptr<const Box> decompress_box(std::span<const std::byte> frame,
                                                        const std::string& origin);

}  // namespace terravox::voxel
