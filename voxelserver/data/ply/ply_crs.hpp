#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "common/geo/crs.hpp"

namespace terravox::ply {

/// The CRS of a file, which the PLY format itself cannot store: from a comment, else from the .prj
/// file of the same name next to it. One that cannot be parsed is logged and treated as absent.
/// @param comment  "EPSG:n", "EPSG:n+m" or WKT; empty when there is none
[[nodiscard]] std::optional<geo::Crs> crs_of(const std::filesystem::path& file,
                                             const std::string& comment);

}  // namespace terravox::ply
