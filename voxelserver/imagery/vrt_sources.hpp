#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

namespace terravox::imagery {

/// The files that a virtual image (.vrt) names as its sources: <SourceFilename> and
/// <SourceDataset>, each once, in the order of the text, which is read without GDAL and without a
/// check of the rest. Names that a .vrt says are relative to it lie in its folder. They need not
/// exist.
/// @param text of the .vrt, or whatever else a file of that ending holds  @param folder of the .vrt
/// @param most no more than so many
[[nodiscard]] std::vector<std::filesystem::path> vrt_sources(std::string_view text,
                                                             const std::filesystem::path& folder,
                                                             std::size_t most);

}  // namespace terravox::imagery
