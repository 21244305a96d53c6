#pragma once

#include <filesystem>
#include <string>

#include "common/voxel/world.hpp"

namespace terravox::voxel {

/// A number for what is in a file: its size, its time, and its first and last 64 KiB; reading all
/// of it would cost as much as is saved by knowing it again. Its name and folder have no part in
/// it.
/// @param what names the kind of file in messages, e.g. "point cloud" @throws Error when it cannot
/// be read
[[nodiscard]] voxel::Fingerprint file_identity(const std::filesystem::path& file, const char* what);

/// 32 hexadecimal digits.
[[nodiscard]] std::string hex_of(const voxel::Fingerprint& print);

}  // namespace terravox::voxel
