#pragma once

#include <filesystem>
#include <memory>

#include "common/voxel/archive/byte_source.hpp"
#include "common/voxel/world.hpp"

namespace terravox::voxel {

/// The world of a box archive. Box, index leaf and header are each checked by checksum when they
/// are read.
/// @throws Error when it is not an archive, another version, unfinished or damaged, or when its
/// bounds do not fit its levels (levels_for()) or its index
[[nodiscard]] std::unique_ptr<World> open_archive(std::unique_ptr<archive::ByteSource> source);

/// Whether a file begins like a box archive.
[[nodiscard]] bool is_archive(const std::filesystem::path& file);

}  // namespace terravox::voxel
