#pragma once

#include <filesystem>
#include <memory>

#include "voxelserver/make/worlds/minecraft/source.hpp"

namespace terravox::minecraft {

/// The files of a ZIP file.
/// @throws Error when it is not a ZIP file, or holds more than FileSource::kMaxEntries
[[nodiscard]] std::unique_ptr<FileSource> open_zip(const std::filesystem::path& path,
                                                   std::size_t cache_bytes);

}  // namespace terravox::minecraft
