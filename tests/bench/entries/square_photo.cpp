#include "tests/bench/entries/square_photo.hpp"
#include "common/geo/gdal.hpp"

#include <gdal_priv.h>

#include "common/util/error.hpp"
#include "voxelserver/tools/survey/geotiff.hpp"

namespace terravox::bench {
namespace {

constexpr const char* kPng = "bench/462_101.png";
constexpr survey::SquareExtent kExtent{462000, 101000, 1000};
constexpr std::int32_t kWest = 462020;
constexpr std::int32_t kNorth = 101980;
constexpr std::int32_t kSide = 960;

survey::SquareRaster<std::uint8_t> read_png(const std::filesystem::path& path) {
    geo::start_gdal();
    const GDALDatasetUniquePtr image{GDALDataset::Open(path.c_str(), GDAL_OF_RASTER)};
    const int side = kExtent.size_m;
    if (!image || image->GetRasterXSize() != side || image->GetRasterYSize() != side ||
        image->GetRasterCount() < 3)
        throw util::Error("read " + path.string() +
                          ": not an image of 1000 x 1000 pixels in three bands");
    survey::SquareRaster<std::uint8_t> out{side, 3, {}};
    out.pixels.resize(std::size_t{3} * static_cast<std::size_t>(side) *
                      static_cast<std::size_t>(side));
    if (image->RasterIO(GF_Read, 0, 0, side, side, out.pixels.data(), side, side, GDT_Byte, 3,
                        nullptr, 3, GSpacing{3} * side, 1, nullptr) != CE_None)
        throw util::Error("read " + path.string() + ": " + CPLGetLastErrorMsg());
    return out;
}

}  // namespace

std::filesystem::path square_photo(const Context& context) {
    const auto path = context.scratch / "square-photo" / "462_101.tif";
    if (!std::filesystem::exists(path))
        survey::write_geotiff(path, kExtent, read_png(context.data / kPng));
    return path;
}

std::string square_and_photo_missing(const Context& context) {
    if (const std::string reason = square().missing(context); !reason.empty())
        return reason;
    std::error_code ignored;
    if (std::filesystem::is_regular_file(context.data / kPng, ignored))
        return {};
    return std::string("no ") + kPng + " in " + context.data.string() + " (--data)";
}

voxelize::LidarWorldOptions square_options(const Context& context, int threads) {
    voxelize::LidarWorldOptions options;
    options.files = square().paths(context);
    options.orthophotos = {square_photo(context)};
    options.classes = square().classes;
    options.crs = square().crs;
    options.threads = threads;
    return options;
}

std::vector<BoxColumnKey> benchmark_columns() {
    const auto range =
        voxel::boxes_over({{kWest, 0, -kNorth}, {kWest + kSide, 1, -kNorth + kSide}}, 0);
    std::vector<BoxColumnKey> out;
    for (std::int32_t bz = range.min.bz; bz < range.max.bz; ++bz)
        for (std::int32_t bx = range.min.bx; bx < range.max.bx; ++bx)
            out.push_back({bx, bz});
    return out;
}

}  // namespace terravox::bench
