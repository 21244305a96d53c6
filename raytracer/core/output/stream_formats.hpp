#pragma once

#include "raytracer/core/output/tile_stream.hpp"

namespace terravox::output {

/// Through OpenEXR; tiles in any order, as its random line order allows, so that none is
/// buffered in memory.
[[nodiscard]] std::unique_ptr<TileStream::Format> make_exr_stream(const std::filesystem::path& file,
                                                                  const StreamShape& shape,
                                                                  PictureInfo info);
/// Through GDAL; only its block cache (common/geo/gdal.hpp) buffers tiles in memory.
[[nodiscard]] std::unique_ptr<TileStream::Format> make_tiff_stream(
    const std::filesystem::path& file, const StreamShape& shape, PictureInfo info);

/// Edge of the tiles in the file: that of the plan's tiles or a divisor of it, so that each of
/// those fills whole tiles of the file.
[[nodiscard]] int file_tile_px(int tile_px, int multiple_of) noexcept;

}  // namespace terravox::output
