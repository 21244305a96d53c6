#pragma once

#include <vector>

#include "voxelserver/serve/map/hill_shade.hpp"
#include "voxelserver/serve/map/top_source.hpp"

namespace terravox::map {

/// The shaded image of kTileBoxes x kTileBoxes box columns.
struct FinestTile {
    /// 256 x 256, row by row from the north-west; empty: there is nothing.
    std::vector<Rgba8> pixels;
    bool complete = true;      ///< whether all box columns that it depends on were known
    voxel::InputExtent reach;  ///< reach of those box columns
};

/// Makes a tile from its box columns and, where the tile's edge is not empty, from those of the
/// ring around it, which shading needs.
/// @param x, z the tile's first box column is (x, z) * kTileBoxes
/// @param world box columns that may contain anything; others are not requested
/// @throws what the source throws
[[nodiscard]] FinestTile make_finest_tile(TopSource& source, const voxel::InputExtent& world,
                                          std::int32_t x, std::int32_t z, bool make);

}  // namespace terravox::map
