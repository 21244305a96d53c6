#pragma once

#include <filesystem>
#include <string>

#include "common/voxel/world.hpp"

namespace terravox::voxel {

/// A fingerprint of a file's content, computed from its size, its modification time, and its first
/// and last 64 KiB: reading all of it would cost as much as a cache hit saves. Its name and folder
/// are not included.
/// @param what the kind of file, for messages, e.g. "point cloud"
/// @throws Error when it cannot be read
[[nodiscard]] voxel::Fingerprint file_identity(const std::filesystem::path& file, const char* what);

/// Formats a fingerprint as 32 hexadecimal digits.
[[nodiscard]] std::string hex_of(const voxel::Fingerprint& print);

}  // namespace terravox::voxel
