#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "raytracer/farm/checkpoint/tile_journal.hpp"
#include "raytracer/farm/render/statistics.hpp"

namespace terravox::render {

struct PictureOptions {
    /// Pictures whose film would take more than half of it are streamed to their files tile by
    /// tile.
    std::size_t memory_mib = 2048;
    int threads = 1;  ///< for denoising and for writing files, at least 1
};

/// Checks, before anything is written, that all files can be.
/// @throws UsageError, Error
void check_joined_pictures(const farm::PictureKey& key, const std::vector<std::string>& files,
                           const PictureOptions& options);

/// Metadata of a picture or raster whose tiles are joined: those of one rendered in one go.
/// @throws UsageError for a scene that has no view of this world
[[nodiscard]] output::PictureInfo joined_picture_info(const scene::Scene& scene,
                                                      const voxel::WorldInfo& world,
                                                      const RenderStatistics& statistics);

/// Writes the pictures that a coordinator with all the tiles would have written: EXR files of the
/// same pixels, PNG, JPEG and TIFF files of the same pixels and metadata. The cost of a run (times,
/// boxes) is not known, and not stored.
/// @param tiles must be complete
/// @return counts, holes and damage of the picture
/// @throws Error, UsageError
RenderStatistics write_joined_pictures(const farm::JoinedTiles& tiles,
                                       const std::vector<std::string>& files,
                                       const PictureOptions& options);

}  // namespace terravox::render
