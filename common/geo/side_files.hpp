#pragma once

#include <filesystem>
#include <vector>

namespace terravox::geo {

/// The files beside a raster that may tell where it lies, or hold its overviews and masks: world
/// files, .prj, .tab, .hdr, .aux.xml, .ovr, .msk, in small letters and in capitals. They need not
/// exist. Looks at nothing but the name.
[[nodiscard]] std::vector<std::filesystem::path> side_files(const std::filesystem::path& raster);

}  // namespace terravox::geo
