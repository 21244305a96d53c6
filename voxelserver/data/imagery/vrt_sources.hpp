#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

namespace terravox::imagery {

/// Lists the source files of a virtual image (.vrt): <SourceFilename> and <SourceDataset>, each
/// once, in the order of the text, which is scanned without GDAL and without validating the rest.
/// Names marked as relative to the .vrt are resolved against its folder. The files need not exist.
/// @param text content of the .vrt, or of any other file with that ending
/// @param folder folder of the .vrt
/// @param most maximum number of files to return
[[nodiscard]] std::vector<std::filesystem::path> vrt_sources(std::string_view text,
                                                             const std::filesystem::path& folder,
                                                             std::size_t most);

}  // namespace terravox::imagery
