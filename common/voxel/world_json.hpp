#pragma once

#include <string>

#include "common/voxel/world.hpp"

namespace terravox::voxel {

inline constexpr int kWorldVersion = 2;  ///< version of the HTTP interface: /v2

/// The response body of GET /v2/world (docs/formats/http.md).
[[nodiscard]] std::string world_to_json(const WorldInfo& info);

/// The inverse of world_to_json(), for untrusted text.
/// @param origin names the text in error messages
/// @throws Error for a wrong version, a missing or invalid value, or bounds that are too large for
/// the number of levels: the boxes of the coarsest level over them are at most 16,384 on an edge
/// and 4,194,304 in all, so that rendering a world of air terminates
[[nodiscard]] WorldInfo world_from_json(const std::string& text, const std::string& origin);

}  // namespace terravox::voxel
