#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "common/voxel/box.hpp"

namespace terravox::voxel {

inline constexpr const char* kBoxMediaType = "application/vnd.terravox.box";

/// Compresses the box's blob to one zstd frame (docs/formats/box.md). The same box and level give
/// the same bytes on every machine.
[[nodiscard]] std::vector<std::byte> compress(const Box& box, int zstd_level = 1);

/// The inverse of compress(), for untrusted input.
/// @param origin names the box in error messages
/// @throws Error for a damaged or foreign frame, or one whose declared size exceeds that of any box
[[nodiscard]] std::shared_ptr<const Box> decompress_box(std::span<const std::byte> frame,
                                                        const std::string& origin);

}  // namespace terravox::voxel
