#include "raytracer/apps/pmtiles/web_area.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "common/geo/crs.hpp"
#include "common/util/error.hpp"

namespace terravox::pmtiles {

std::uint64_t tile_id(const TileAddress& tile) noexcept {
    // As many tiles as all coarser zooms have: 1 + 4 + 16 + ...
    const std::uint64_t before = ((std::uint64_t{1} << (2 * tile.zoom)) - 1) / 3;
    std::uint64_t along = 0;
    std::uint32_t x = tile.column;
    std::uint32_t y = tile.row;
    // Quadrant by quadrant, from the whole square down to single tiles. The curve visits the
    // quadrants as a U; its first and last quarter are the curve, mirrored at a diagonal.
    for (int bit = tile.zoom - 1; bit >= 0; --bit) {
        const bool east = (x >> bit & 1) != 0;
        const bool south = (y >> bit & 1) != 0;
        const std::uint64_t quarter = east ? (south ? 2 : 3) : (south ? 1 : 0);
        along = along << 2 | quarter;
        if (!south && east) {
            x = ~x;
            y = ~y;
        }
        if (!south)
            std::swap(x, y);
    }
    return before + along;
}

namespace {

/// From the middle of Web Mercator to its border, metres: half of the equator.
constexpr double kHalf_m = std::numbers::pi * 6'378'137;

/// Edge of a tile, metres.
double edge_m(int zoom) noexcept {
    return std::ldexp(2 * kHalf_m, -zoom);
}

double degrees_east(double x) noexcept {
    return x / kHalf_m * 180;
}

// Ref: Snyder, "Map Projections: A Working Manual", USGS Professional Paper 1395, 1987, (7-4).
double degrees_north(double y) noexcept {
    return std::atan(std::sinh(y / kHalf_m * std::numbers::pi)) * 180 / std::numbers::pi;
}

/// Points of Web Mercator, metres.
struct Points {
    std::vector<double> x;
    std::vector<double> y;
};

/// Where pixels of a map lie.
Points in_web_mercator(const output::GeoPlacement& placement,
                       const std::vector<std::array<double, 2>>& pixels,
                       const std::string& attempt) {
    const std::array<double, 6>& t = placement.transform;
    Points out;
    for (const auto& [column, row] : pixels) {
        out.x.push_back(t[0] + column * t[1] + row * t[2]);
        out.y.push_back(t[3] + column * t[4] + row * t[5]);
    }
    try {
        const geo::Transform transform(geo::Crs::from_wkt(placement.crs_wkt),
                                       geo::Crs::from_text("EPSG:3857"));
        transform.apply(out.x, out.y);
    } catch (const util::Error& e) {
        throw util::UsageError(attempt + ": " + e.what());
    }
    return out;
}

/// Points along the border of a map, whose sides are bent in Web Mercator.
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

/// The zoom at which a pixel has an edge, not rounded.
double find_zoom(double pixel_m, int tile_px) noexcept {
    return std::log2(2 * kHalf_m / tile_px / pixel_m);
}

int whole_zoom(double zoom) noexcept {
    return static_cast<int>(std::clamp(zoom, 0.0, static_cast<double>(TileAddress::kMaxZoom)));
}

}  // namespace

std::array<double, 4> WebArea::bounds_deg() const noexcept {
    const auto& [west, south, east, north] = bounds;
    return {degrees_east(west), degrees_north(south), degrees_east(east), degrees_north(north)};
}

void WebArea::choose_zooms(int first, int last, const std::string& attempt) {
    if (first < 0 || first > last || last > max_zoom)
        throw util::UsageError(attempt + ": zooms " + std::to_string(first) + " to " +
                               std::to_string(last) + "; allowed: 0 to " +
                               std::to_string(max_zoom) +
                               ", whose pixels are those of the map; a "
                               "finer --resolution gives more");
    min_zoom = first;
    max_zoom = last;
}

std::vector<TileAddress> WebArea::tiles(int zoom) const {
    const auto& [west, south, east, north] = bounds;
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

std::array<double, 4> WebArea::measure_bounds(const TileAddress& tile) noexcept {
    const double edge = edge_m(tile.zoom);
    const double west = tile.column * edge - kHalf_m;
    const double north = kHalf_m - tile.row * edge;
    return {west, north - edge, west + edge, north};
}

WebArea to_web_area(const output::GeoPlacement& placement, int width, int height, int tile_px,
                    const std::string& attempt) {
    if (placement.crs_wkt.empty())
        throw util::UsageError(attempt +
                               ": it has no place on Earth; allowed: worlds with a CRS; .tif needs "
                               "none");
    const Points around = in_web_mercator(placement, border(width, height), attempt);
    const auto [west, east] = std::minmax_element(around.x.begin(), around.x.end());
    const auto [south, north] = std::minmax_element(around.y.begin(), around.y.end());
    WebArea out;
    out.tile_px = tile_px;
    out.bounds = {*west, *south, *east, *north};
    if (!(*west >= -kHalf_m && *east <= kHalf_m && *south >= -kHalf_m && *north <= kHalf_m))
        throw util::UsageError(attempt +
                               ": it reaches beyond Web Mercator; allowed: 85 degrees south to 85 "
                               "degrees north");
    // The short way round the Earth crosses the border, where the map would be in two parts.
    if (*east - *west > kHalf_m)
        throw util::UsageError(attempt +
                               ": it lies on both sides of 180 degrees east; allowed: an --area on "
                               "one side of it");
    const Points middle = in_web_mercator(
        placement, {{width / 2.0, height / 2.0}, {width / 2.0 + 1, height / 2.0}}, attempt);
    constexpr double kTenth = 0.1375;  // of a pixel, in zooms: log2(1.1)
    constexpr double kFew_px = 64;
    const double cell_m = std::hypot(middle.x[1] - middle.x[0], middle.y[1] - middle.y[0]);
    const double few_m = std::max(*east - *west, *north - *south) / kFew_px;
    out.max_zoom = whole_zoom(std::ceil(find_zoom(cell_m, tile_px) - kTenth));
    out.min_zoom = std::min(whole_zoom(std::round(find_zoom(few_m, tile_px))), out.max_zoom);
    return out;
}

}  // namespace terravox::pmtiles
