#pragma once

#include <vector>

#include "voxelserver/map/hill_shade.hpp"
#include "voxelserver/map/top_source.hpp"

namespace terravox::map {

/// The shaded picture of kTileBoxes x kTileBoxes box columns.
struct FinestTile {
    std::vector<Rgba8>
        pixels;            ///< 256 x 256, row by row from the north-west; none: nothing is there
    bool complete = true;  ///< all box columns that it depends on were known
    voxel::InputExtent reach;  ///< of those
};

/// Asks for the tile's box columns, and for those of the ring around it that shading looks at:
/// where the tile's edge has something.
/// @param x, z the tile's first box column is (x, z) * kTileBoxes
/// @param world box columns that may hold anything; others are not asked for
/// @throws what the source throws
[[nodiscard]] FinestTile make_finest_tile(TopSource& source, const voxel::InputExtent& world,
                                          std::int32_t x, std::int32_t z, bool make);

}  // namespace terravox::map
