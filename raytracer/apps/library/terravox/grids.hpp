#pragma once

#include <terravox/place.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace terravox {

/// Materials of a block of voxels.
struct VoxelGrid {
    VoxelBlock block;
    MapBounds bounds;  ///< of the block
    /// Sizes of the array: layers from the bottom up, rows from the north, columns from the west.
    std::array<std::size_t, 3> shape{};
    /// Numbers of terravox::materials(); 0: air. Voxels behind others on all sides are rock: worlds
    /// keep materials where they can be seen.
    std::vector<std::uint8_t> materials;
    std::size_t holes = 0;  ///< boxes that could not be read, which are air here
};

/// Values on a grid of square cells, seen from above.
struct Raster {
    MapBounds bounds;
    double cell = 1;          ///< edge of a cell, units of the map
    std::size_t rows = 0;     ///< from the north
    std::size_t columns = 0;  ///< from the west
    struct Band {
        std::string name;  ///< "dsm"
        std::string unit;  ///< "m"; empty: none
        /// rows x columns; NaN where there is no value.
        std::vector<float> values;
    };
    std::vector<Band> bands;
    /// Boxes that could not be read. Cells that needed them have no values.
    std::size_t holes = 0;
};

}  // namespace terravox
