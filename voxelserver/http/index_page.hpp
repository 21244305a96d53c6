#pragma once

#include <string>
#include <string_view>

#include "common/voxel/world.hpp"

namespace terravox::http {

[[nodiscard]] std::string escape_html(std::string_view text);

/// The page at /: the world and the HTTP interface. Self-contained: it loads nothing.
[[nodiscard]] std::string index_page(const voxel::WorldInfo& info);

}  // namespace terravox::http
