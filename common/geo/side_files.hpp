#pragma once

#include <filesystem>
#include <vector>

namespace terravox::geo {

/// The names of the files next to a raster that may georeference it, or hold its overviews and
/// masks: world files, .prj, .tab, .hdr, .aux.xml, .ovr, .msk, in lower and in upper case. They
/// need not exist. Computed from the name alone, without accessing the file system.
[[nodiscard]] std::vector<std::filesystem::path> side_files(const std::filesystem::path& raster);

}  // namespace terravox::geo
