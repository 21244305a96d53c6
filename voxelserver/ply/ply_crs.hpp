#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "common/geo/crs.hpp"

namespace terravox::ply {

/// The CRS of a file, which PLY itself has no place for: what a comment says, else the .prj file of
/// the same name beside it. What cannot be understood is reported in the log and counts as none.
/// @param comment  "EPSG:n", "EPSG:n+m" or WKT; empty when there is none
[[nodiscard]] std::optional<geo::Crs> crs_of(const std::filesystem::path& file,
                                             const std::string& comment);

}  // namespace terravox::ply
