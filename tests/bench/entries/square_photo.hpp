#pragma once

#include "tests/bench/entries/data_sets.hpp"

namespace terravox::bench {

/// The orthophoto of the full square: the PNG of the shared data has no georeference, so a GeoTIFF
/// of it is made in scratch (once).
/// @throws Error when the PNG cannot be read
[[nodiscard]] std::filesystem::path square_photo(const Context& context);

/// Why the square or its photo cannot be used; empty when both are there.
[[nodiscard]] std::string square_and_photo_missing(const Context& context);

/// Options for a world of the full square with everything on.
[[nodiscard]] voxelize::LidarWorldOptions square_options(const Context& context, int threads);

/// The box columns over the 960 x 960 m that the first system was measured on: 15 x 15 boxes of 64
/// m from easting 462020, northing 101980. Boxes lie on an absolute grid here, so 16 x 16 columns
/// of them cover that.
struct BoxColumnKey {
    std::int32_t bx = 0;
    std::int32_t bz = 0;
};
[[nodiscard]] std::vector<BoxColumnKey> benchmark_columns();

}  // namespace terravox::bench
