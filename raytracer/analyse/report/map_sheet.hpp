#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "raytracer/analyse/raster/cell_file.hpp"
#include "raytracer/analyse/report/legend.hpp"

namespace terravox::analyse {

/// A picture of a raster, seen from above, north up.
struct MapPicture {
    int width = 0;
    int height = 0;
    double cells_per_px = 1;
    std::vector<map::Rgba8> pixels;  ///< row by row from the top
};

/// Draws a band: cells without a value are grey, and magenta where data could not be read. A large
/// raster is drawn smaller, by means of cells or, of categories, by single ones; a small one
/// larger, with whole pixels for each cell.
/// @param most_px of the longer side, at least 1
/// @throws Error as CellFile
[[nodiscard]] MapPicture draw_band(CellFile& cells, std::string_view band, const Legend& legend,
                                   int most_px);

/// What stands around a map. UTF-8; what is too long for the sheet is cut.
struct SheetFacts {
    std::string title;
    std::string unit;    ///< of the values; empty: none
    std::string credit;  ///< attribution of the data; empty: none
    double cell_m = 1;   ///< edge of a cell
};

/// A map with its title, legend, a scale of lengths and the credit, as a PNG file.
/// @throws Error
[[nodiscard]] std::string map_sheet(const MapPicture& picture, const Legend& legend,
                                    const SheetFacts& facts);

}  // namespace terravox::analyse
