#pragma once

#include <filesystem>
#include <memory>

#include "common/voxel/archive/byte_source.hpp"
#include "common/voxel/world.hpp"

namespace terravox::voxel {

/// Opens a box archive as a world. The checksum of a box, index leaf or header is verified whenever
/// it is read.
/// @throws Error when the file is not an archive, has another version, is unfinished or damaged, or
/// when its bounds are inconsistent with its levels (levels_for()) or its index
[[nodiscard]] std::unique_ptr<World> open_archive(std::unique_ptr<archive::ByteSource> source);

/// Whether a file begins like a box archive, or a shard or change of one; the rest is not
/// checked.
[[nodiscard]] bool is_archive(const std::filesystem::path& file);

}  // namespace terravox::voxel
