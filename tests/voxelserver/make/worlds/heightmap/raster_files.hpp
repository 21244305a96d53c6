#pragma once

#include <filesystem>
#include <functional>

#include "tests/voxelserver/image_file.hpp"

namespace terravox::test {

/// A raster of heights to be written: cells of 1 m in Slovenia.
struct RasterSpec : ImageFile {
    RasterSpec() {
        height = 80;
        bands = 1;
        geo = {460'000, 1, 0, 101'080, 0, -1};
        crs = "EPSG:3794";
        type = GDT_Float32;
    }
};

/// @param heights of column and row
inline std::filesystem::path write_heights(const std::filesystem::path& file, RasterSpec spec,
                                           const std::function<double(int, int)>& heights) {
    spec.value = [&](int x, int y, int) { return heights(x, y); };
    write_image(file, spec);
    return file;
}

}  // namespace terravox::test
