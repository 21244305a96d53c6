#include "raytracer/pmtiles/tile_cutter.hpp"

#include <gdal_utils.h>
#include <ogr_spatialref.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <numbers>
#include <string>
#include <utility>

#include "common/geo/crs.hpp"
#include "common/util/error.hpp"
#include "raytracer/output/gdal_writing.hpp"

namespace terravox::pmtiles {
namespace {

constexpr int kBands = 4;
/// From the middle of the web's map to its border, metres: half of the equator.
constexpr double kHalf_m = std::numbers::pi * 6'378'137;

/// Edge of a tile, metres of EPSG:3857.
double edge_m(int zoom) noexcept {
    return std::ldexp(2 * kHalf_m, -zoom);
}

struct OptionsFree {
    void operator()(GDALWarpAppOptions* options) const noexcept { GDALWarpAppOptionsFree(options); }
};

output::GdalDataset open_map(const std::string& file, const output::GdalWatch& watch) {
    const char* const only[] = {"GTiff", nullptr};
    output::GdalDataset out(
        GDALOpenEx(file.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY, only, nullptr, nullptr));
    watch.check(out != nullptr);
    return out;
}

double degrees_east(double x) noexcept {
    return x / kHalf_m * 180;
}

// Ref: Snyder, "Map Projections: A Working Manual", USGS Professional Paper 1395, 1987, (7-4).
double degrees_north(double y) noexcept {
    return std::atan(std::sinh(y / kHalf_m * std::numbers::pi)) * 180 / std::numbers::pi;
}

/// Points of the web's map.
struct Points {
    std::vector<double> x;
    std::vector<double> y;
};

/// Where points of a raster, in pixels, lie on the web's map.
Points on_web_map(GDALDatasetH map, const std::vector<std::array<double, 2>>& pixels,
                  const std::string& attempt) {
    std::array<double, 6> t{};
    OGRSpatialReferenceH crs = GDALGetSpatialRef(map);
    if (crs == nullptr || GDALGetGeoTransform(map, t.data()) != CE_None)
        throw util::Error(attempt +
                          ": it has no place on Earth; allowed: maps of worlds with a "
                          "CRS");
    Points out;
    for (const auto& [column, row] : pixels) {
        out.x.push_back(t[0] + column * t[1] + row * t[2]);
        out.y.push_back(t[3] + column * t[4] + row * t[5]);
    }
    const geo::Transform to_web(geo::Crs::from_ogr(*OGRSpatialReference::FromHandle(crs), attempt),
                                geo::Crs::from_text("EPSG:3857"));
    to_web.apply(out.x, out.y);
    return out;
}

/// Points along the border of a raster: on the web's map its sides are bent.
std::vector<std::array<double, 2>> border(double width, double height) {
    constexpr int kPoints = 64;
    std::vector<std::array<double, 2>> out;
    for (int i = 0; i <= kPoints; ++i) {
        const double share = i / static_cast<double>(kPoints);
        out.push_back({share * width, 0});
        out.push_back({share * width, height});
        out.push_back({0, share * height});
        out.push_back({width, share * height});
    }
    return out;
}

}  // namespace

/// Open maps, one for each thread that cuts: GDAL's datasets are not thread-safe.
struct TileCutter::Maps {
    explicit Maps(const std::filesystem::path& map)
        : file(map.string()), attempt("cut the map " + file) {}

    /// Lends an open map, and takes it back.
    class Loan {
    public:
        Loan(Maps& maps, const output::GdalWatch& watch) : m_maps(maps) {
            {
                const std::scoped_lock lock(maps.m_mutex);
                if (!maps.m_idle.empty()) {
                    m_map = std::move(maps.m_idle.back());
                    maps.m_idle.pop_back();
                }
            }
            if (!m_map)
                m_map = open_map(maps.file, watch);
        }
        ~Loan() {
            const std::scoped_lock lock(m_maps.m_mutex);
            m_maps.m_idle.push_back(std::move(m_map));
        }
        Loan(const Loan&) = delete;
        Loan& operator=(const Loan&) = delete;
        [[nodiscard]] GDALDatasetH get() const noexcept { return m_map.get(); }

    private:
        Maps& m_maps;
        output::GdalDataset m_map;
    };

    const std::string file;
    const std::string attempt;

private:
    std::mutex m_mutex;
    std::vector<output::GdalDataset> m_idle;
};

TileCutter::TileCutter(const std::filesystem::path& map) : m_maps(std::make_unique<Maps>(map)) {
    const output::GdalWatch watch(m_maps->attempt);
    const Maps::Loan loan(*m_maps, watch);
    if (GDALGetRasterCount(loan.get()) != kBands)
        throw util::Error(m_maps->attempt + ": " + std::to_string(GDALGetRasterCount(loan.get())) +
                          " bands; allowed: 4, red, green, blue and alpha");
    const double width = GDALGetRasterXSize(loan.get());
    const double height = GDALGetRasterYSize(loan.get());
    const Points around = on_web_map(loan.get(), border(width, height), m_maps->attempt);
    const auto [west, east] = std::minmax_element(around.x.begin(), around.x.end());
    const auto [south, north] = std::minmax_element(around.y.begin(), around.y.end());
    m_bounds = {*west, *south, *east, *north};
    if (!(*west >= -kHalf_m && *east <= kHalf_m && *south >= -kHalf_m && *north <= kHalf_m))
        throw util::Error(m_maps->attempt +
                          ": it reaches beyond the web's map; allowed: 85 degrees south to 85 "
                          "degrees north");
    const Points middle = on_web_map(
        loan.get(), {{width / 2, height / 2}, {width / 2 + 1, height / 2}}, m_maps->attempt);
    const double pixel_m = std::hypot(middle.x[1] - middle.x[0], middle.y[1] - middle.y[0]);
    const auto zoom_of = [](double metres_per_px) {
        return std::clamp(
            static_cast<int>(std::lround(std::log2(2 * kHalf_m / kTile_px / metres_per_px))), 0,
            TileAddress::kMaxZoom);
    };
    constexpr double kFew_px = 64;
    m_max_zoom = zoom_of(pixel_m);
    m_min_zoom = std::min(zoom_of(std::max(*east - *west, *north - *south) / kFew_px), m_max_zoom);
}

TileCutter::~TileCutter() = default;

std::array<double, 4> TileCutter::bounds_deg() const noexcept {
    const auto& [west, south, east, north] = m_bounds;
    return {degrees_east(west), degrees_north(south), degrees_east(east), degrees_north(north)};
}

std::vector<TileAddress> TileCutter::tiles(int zoom) const {
    const auto& [west, south, east, north] = m_bounds;
    const double edge = edge_m(zoom);
    const double last = std::ldexp(1.0, zoom) - 1;
    const auto place = [&](double metres) {
        return static_cast<std::uint32_t>(std::clamp(std::floor(metres / edge), 0.0, last));
    };
    std::vector<TileAddress> out;
    for (std::uint32_t row = place(kHalf_m - north); row <= place(kHalf_m - south); ++row)
        for (std::uint32_t column = place(west + kHalf_m); column <= place(east + kHalf_m);
             ++column)
            out.push_back({zoom, column, row});
    std::sort(out.begin(), out.end(),
              [](const TileAddress& a, const TileAddress& b) { return tile_id(a) < tile_id(b); });
    return out;
}

std::vector<map::Rgba8> TileCutter::cut(const TileAddress& tile) const {
    const output::GdalWatch watch(m_maps->attempt);
    const Maps::Loan loan(*m_maps, watch);
    const double edge = edge_m(tile.zoom);
    const double west = tile.column * edge - kHalf_m;
    const double north = kHalf_m - tile.row * edge;
    const std::string side = std::to_string(kTile_px);
    const auto metres = [](double v) {
        char text[32];
        std::snprintf(text, sizeof text, "%.4f", v);
        return std::string(text);
    };
    std::vector<std::string> words = {"-of",
                                      "MEM",
                                      "-t_srs",
                                      "EPSG:3857",
                                      "-te",
                                      metres(west),
                                      metres(north - edge),
                                      metres(west + edge),
                                      metres(north),
                                      "-ts",
                                      side,
                                      side,
                                      "-r",
                                      "bilinear",
                                      "-srcalpha",
                                      "-dstalpha"};
    std::vector<char*> pointers;
    for (std::string& word : words)
        pointers.push_back(word.data());
    pointers.push_back(nullptr);
    const std::unique_ptr<GDALWarpAppOptions, OptionsFree> options(
        GDALWarpAppOptionsNew(pointers.data(), nullptr));
    GDALDatasetH from = loan.get();
    const output::GdalDataset warped(GDALWarp("", nullptr, 1, &from, options.get(), nullptr));
    watch.check(warped != nullptr);
    std::vector<map::Rgba8> out(static_cast<std::size_t>(kTile_px) * kTile_px);
    static_assert(sizeof(map::Rgba8) == kBands);
    watch.check(GDALDatasetRasterIOEx(warped.get(), GF_Read, 0, 0, kTile_px, kTile_px, out.data(),
                                      kTile_px, kTile_px, GDT_Byte, kBands, nullptr, kBands,
                                      GSpacing{kBands} * kTile_px, 1, nullptr) == CE_None);
    if (std::none_of(out.begin(), out.end(), [](const map::Rgba8& pixel) { return pixel.a > 0; }))
        out.clear();
    return out;
}

}  // namespace terravox::pmtiles
