#pragma once

#include <filesystem>

namespace terravox::geo {

/// Checks a virtual raster (.vrt) before GDAL opens it. A .vrt can act like a program: it names
/// files and addresses to read, can read any file as raw values, and may call code. Here only
/// mosaics are accepted: bands made of sources (<SimpleSource>, <ComplexSource> and related
/// elements, masks and overviews), where each source is a file next to or below the .vrt, after
/// resolving all links. Refused: raw, derived, warped and pansharpened bands, open options, names
/// relative to the working directory, .vrt nested deeper than 4, more than 64 MiB of text in all.
/// Thread-safe.
/// @throws Error with the reason, without the name of the file
void check_virtual_raster(const std::filesystem::path& vrt);

/// Whether a file lies in the folder or below it, after resolving all links; a file that does not
/// exist is judged by where it would lie.
[[nodiscard]] bool lies_in(const std::filesystem::path& file, const std::filesystem::path& folder);

}  // namespace terravox::geo
