#pragma once

#include <nlohmann/json.hpp>

#include "common/voxel/archive/archive_reader.hpp"

namespace terravox::voxel::archive {

/// Reads the JSON with which a shard or a change ends, and compares its checksum.
/// @param what the file is, for messages: "shard"
/// @throws Error when it is damaged
[[nodiscard]] nlohmann::json end_json(ByteSource& source, const ArchiveIndex& index,
                                      const char* what);

}  // namespace terravox::voxel::archive
