#pragma once

#include <filesystem>

namespace terravox::geo {

/// Looks at a virtual raster (.vrt) before GDAL opens it. A .vrt is a program of sorts: it names
/// files and addresses to read, takes any file for raw values, and may call code. Here it is a
/// mosaic and nothing else: bands made of sources
/// (<SimpleSource>, <ComplexSource> and their kin, masks and overviews), each source a file beside
/// or below it, after all links. Refused: raw, derived, warped and pansharpened bands, options for
/// opening, names relative to where the program runs, .vrt in .vrt deeper than 4, more than 64 MiB
/// of text in all. Thread-safe.
/// @throws Error saying why, without the name of the file
void check_virtual_raster(const std::filesystem::path& vrt);

/// Whether a file lies in the folder or below it, after all links; a file that does not exist where
/// it would lie.
[[nodiscard]] bool lies_in(const std::filesystem::path& file, const std::filesystem::path& folder);

}  // namespace terravox::geo
