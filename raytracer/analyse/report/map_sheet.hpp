#pragma once

#include <string>

#include "raytracer/analyse/report/map_picture.hpp"

namespace terravox::analyse {

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
