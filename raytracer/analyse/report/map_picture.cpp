#include "raytracer/analyse/report/map_picture.hpp"

#include <algorithm>
#include <cmath>

namespace terravox::analyse {
namespace {

constexpr map::Rgba8 kNothing{218, 218, 218, 255};
constexpr map::Rgba8 kHole{255, 0, 204, 255};

struct Size {
    int width = 0;
    int height = 0;
};

Size drawn_size(const CellFile& cells, int most_px) {
    const int longer = std::max(cells.columns(), cells.rows());
    if (longer <= most_px) {
        const int times = most_px / longer;
        return {cells.columns() * times, cells.rows() * times};
    }
    const double share = static_cast<double>(most_px) / longer;
    const auto scaled = [&](int side) {
        return std::max(1, static_cast<int>(std::lround(side * share)));
    };
    return {scaled(cells.columns()), scaled(cells.rows())};
}

std::vector<float> read_at(CellFile& cells, int band, Size size, GDALRIOResampleAlg how) {
    std::vector<float> out(static_cast<std::size_t>(size.width) *
                           static_cast<std::size_t>(size.height));
    const output::GdalWatch watch("draw a band of the raster");
    GDALRasterIOExtraArg extra;
    INIT_RASTERIO_EXTRA_ARG(extra);
    extra.eResampleAlg = how;
    watch.check(GDALRasterIOEx(GDALGetRasterBand(cells.dataset(), band), GF_Read, 0, 0,
                               cells.columns(), cells.rows(), out.data(), size.width, size.height,
                               GDT_Float32, 0, 0, &extra) == CE_None);
    return out;
}

}  // namespace

MapPicture draw_band(CellFile& cells, core::AnalysisKind kind, int band, const Legend& legend,
                     int most_px) {
    const Size size = drawn_size(cells, most_px);
    const bool is_smaller = size.width < cells.columns();
    // The mean of 359 and 1 degrees is none.
    const bool has_means =
        is_smaller && !has_categories(legend.ramp) && legend.ramp != Ramp::kAround;
    const auto values =
        read_at(cells, band, size, has_means ? GRIORA_Average : GRIORA_NearestNeighbour);
    const auto holes = read_at(cells, band_number(kind, kHoleBand), size,
                               is_smaller ? GRIORA_Average : GRIORA_NearestNeighbour);
    MapPicture out;
    out.width = size.width;
    out.height = size.height;
    out.cells_per_px = static_cast<double>(cells.columns()) / size.width;
    out.pixels.reserve(values.size());
    for (std::size_t i = 0; i < values.size(); ++i) {
        if (holes[i] > 0)
            out.pixels.push_back(kHole);
        else if (values[i] != core::kNoData)
            out.pixels.push_back(legend.colour_of(static_cast<double>(values[i])));
        else
            out.pixels.push_back(kNothing);
    }
    return out;
}

}  // namespace terravox::analyse
