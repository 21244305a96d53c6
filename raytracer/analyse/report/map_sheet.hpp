#pragma once

#include <optional>
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

/// A band with what is to be said of it.
struct BandFacts {
    RasterBand band;
    BandStatistics statistics;
    std::optional<Legend> legend;  ///< where it has a style and values
};

/// A map with its title, a scale of lengths, an arrow to the north, its legend and the credit, as
/// an SVG element on white. The legend of a measure has a chart of how much area has which values,
/// that of categories the area of each. All words are text, in a font of whoever looks at them.
/// @param band has a legend
/// @param cell_m edge of a cell
/// @param credit attribution of the data, UTF-8; empty: none
/// @param is_file a file of its own, instead of a part of a page
/// @throws Error
[[nodiscard]] std::string map_sheet(const MapPicture& picture, const BandFacts& band, double cell_m,
                                    std::string_view credit, bool is_file);

}  // namespace terravox::analyse
