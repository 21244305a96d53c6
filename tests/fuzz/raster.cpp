// Rasters: TIFF, .vrt and other formats behind the gate, read as heights. The first byte chooses.
#include <algorithm>
#include <array>

#include "common/geo/gdal.hpp"
#include "tests/fuzz/fuzz.hpp"
#include "voxelserver/make/worlds/heightmap/height_file.hpp"

namespace terravox::fuzz {
namespace {

// Names by which GDAL finds the driver; N46E014.hgt names the place, as SRTM requires.
constexpr std::array kNames{
    "input.tif", "input.vrt", "input.asc", "input.png", "N46E014.hgt", "input.xyz", "input.jpg",
};
constexpr double kMaxCells = 100'000;
constexpr int kWindow = 64;

}  // namespace

void run(Input input) {
    if (input.empty())
        return;
    geo::start_gdal();
    const auto file = as_file(input.subspan(1), kNames[input[0] % kNames.size()]);
    heightmap::Reading reading;
    reading.path = file;
    reading.crs = geo::Crs::from_text("EPSG:3794");
    heightmap::HeightFile heights(reading);
    for (const double side : {1.0, 64.0}) {
        const heightmap::HeightFile::Grid grid = heights.grid_for(side);
        expect(grid.width > 0 && grid.height > 0, "a raster that is accepted has cells");
        const int width = std::min(grid.width, kWindow);
        const int height = std::min(grid.height, kWindow);
        allow_errors([&] {
            const heightmap::Cells cells = heights.read(grid, 0, 0, width, height);
            expect(cells.metres.size() == std::size_t(width) * std::size_t(height),
                   "a window of a grid has all of its cells");
        });
    }
    allow_errors([&] { (void)heights.rough_range(kMaxCells); });
}

}  // namespace terravox::fuzz
