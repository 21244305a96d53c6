#pragma once

#include <string>

#include "common/voxel/world.hpp"

namespace terravox::voxel {

inline constexpr int kWorldVersion = 2;  ///< of the HTTP interface: /v2

/// The reply to GET /v2/world (docs/formats.md).
[[nodiscard]] std::string world_to_json(const WorldInfo& info);

/// The inverse, for text from anywhere. @param origin names it in messages
/// @throws Error for a wrong version, or a missing or impossible value
[[nodiscard]] WorldInfo world_from_json(const std::string& text, const std::string& origin);

}  // namespace terravox::voxel
