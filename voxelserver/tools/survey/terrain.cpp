#include "voxelserver/tools/survey/terrain.hpp"

#include "voxelserver/tools/survey/randomness.hpp"

namespace terravox::survey {
namespace {

/// Part of the radius by which bays and capes deviate from the ellipse.
constexpr double kShoreSway = 0.16;

// Distance from the centre to the shore, for a direction of length 1. Noise over the unit circle
// closes on itself.
double shore_radius(const Lake& lake, Vec2 direction) noexcept {
    const double ex = direction.x / lake.radius_x_m;
    const double ey = direction.y / lake.radius_y_m;
    const double ellipse = 1.0 / std::sqrt(ex * ex + ey * ey);
    const double sway =
        0.75 * noise_2d(lake.seed, direction.x * 1.6 + 7.3, direction.y * 1.6 + 3.1) +
        0.35 * noise_2d(lake.seed + 1, direction.x * 4.5, direction.y * 4.5);
    return ellipse * (1.0 + kShoreSway * std::clamp(sway, -1.0, 1.0));
}

}  // namespace

double Lake::shore_distance(Vec2 p) const noexcept {
    const Vec2 from = p - centre;
    return length(from) - shore_radius(*this, unit(from));
}

Vec2 Lake::shore_point(Vec2 direction) const noexcept {
    return centre + direction * shore_radius(*this, direction);
}

double Lake::reach_m() const noexcept {
    return std::max(radius_x_m, radius_y_m) * (1.0 + kShoreSway);
}

std::vector<Vec2> Lake::shore_ring(int points) const {
    std::vector<Vec2> ring;
    ring.reserve(static_cast<std::size_t>(points));
    // Directions of equal steps along the four sides of a square, then normalised: a circle without
    // sine and cosine.
    for (int i = 0; i < points; ++i) {
        const double s = 8.0 * i / points;
        const double t = s - 2.0 * std::floor(s / 2.0) - 1.0;
        const int side = static_cast<int>(s / 2.0) % 4;
        const Vec2 square = side == 0   ? Vec2{1, t}
                            : side == 1 ? Vec2{-t, 1}
                            : side == 2 ? Vec2{-1, -t}
                                        : Vec2{t, -1};
        ring.push_back(shore_point(unit(square)));
    }
    return ring;
}

River::River(std::uint64_t seed, std::int64_t index) noexcept
    : m_seed(compute_hash(seed, 0x52, index)),
      m_index(index),
      m_base_y(static_cast<double>(index) * kRiverSpacing_m - kRiverSouth_m),
      m_base_level_m(470.0 + (index == 0 ? 0.0 : Random(m_seed).range(-45.0, 45.0))) {}

double River::centre_y(double x) const noexcept {
    // Near the place the river keeps to its bed of the manual layout; farther away it swings
    // freely.
    const double freedom = m_index == 0 ? smoothstep(600.0, 2600.0, std::abs(x)) : 1.0;
    return m_base_y + lerp(15.0, 340.0, freedom) * noise_1d(m_seed, x / 950.0) +
           lerp(20.0, 30.0, freedom) * noise_1d(m_seed + 1, x / 170.0);
}

double River::level_m(double x) const noexcept {
    // 4 m a kilometre at the place, less and less far away, so that the endless river stays between
    // the hills and the sea.
    return m_base_level_m - 0.004 * x / (1.0 + std::abs(x) / 40000.0);
}

double River::half_width_m(double x) const noexcept {
    return 7.0 + 1.6 * noise_1d(m_seed + 2, x / 130.0);
}

RiverAtX River::at(double x) const noexcept {
    const double slope = (centre_y(x + 4.0) - centre_y(x - 4.0)) / 8.0;
    return {centre_y(x), 1.0 / std::sqrt(1.0 + slope * slope), level_m(x), half_width_m(x)};
}

Brook::Spot Brook::nearest(Vec2 p) const noexcept {
    Spot best;
    for (std::size_t i = 1; i < line.size(); ++i) {
        const auto on = nearest_on_segment(p, line[i - 1].at, line[i].at);
        if (on.distance_m < best.distance_m)
            best = {on.distance_m, lerp(line[i - 1].level_m, line[i].level_m, on.along)};
    }
    return best;
}

namespace {

constexpr double kShoreReach_m = 75;  ///< over which the land comes down to a lake
constexpr double kNearWater_m = 2;

// Banks of running water: bed, a bank as steep as 1 : 2, and no land lower than the water next to
// it.
double carve_channel(double ground_m, double distance_m, double half_width_m, double depth_m,
                     double level_m) noexcept {
    const double outside = distance_m - half_width_m;
    if (outside < 0) {
        const double across = distance_m / half_width_m;
        return std::min(ground_m, level_m - 0.15 - depth_m * (1.0 - across * across));
    }
    const double levee =
        level_m + 0.5 * smoothstep(0.0, 2.5, outside) - 0.15 * std::max(0.0, outside - 2.5);
    const double far = std::max(0.0, outside - 20.0);
    const double bank = level_m + 0.08 + 0.5 * outside + 0.03 * far * far;
    return std::min(std::max(ground_m, levee), bank);
}

double island_height(const Mound& island, Vec2 p, std::uint64_t seed) noexcept {
    const double t = island.outwards(p) + 0.07 * noise_2d(seed, p.x / 14.0, p.y / 14.0);
    const double shore = lerp(island.top_m, island.top_m - 13.0, smoothstep(0.58, 1.12, t));
    return shore - 16.0 * std::max(0.0, t - 0.95);
}

// Cliffs to the south, a slope to the north; ledges and gullies by noise that grows with the fall.
double castle_height(const Mound& rock, Vec2 p, std::uint64_t seed) noexcept {
    const Vec2 from = p - rock.centre;
    const double t = rock.outwards(p);
    const double outside = std::max(0.0, (t - 1.0) * std::min(rock.radius_x_m, rock.radius_y_m));
    const double gully =
        noise_2d(seed, p.x / 9.0, p.y / 9.0) + 0.5 * noise_2d(seed + 1, p.x / 4.0, p.y / 4.0);
    const double width = lerp(15.0, 150.0, smoothstep(-0.25, 0.95, from.y / (length(from) + 1e-9)));
    const double fall =
        smoothstep(0.0, 1.0, (outside + 3.2 * gully * smoothstep(0.0, 5.0, outside)) / width);
    return rock.top_m - 100.0 * fall;
}

}  // namespace

Terrain::Terrain(std::uint64_t seed, const Box2& area)
    : m_seed(compute_hash(seed, 0x7E)), m_sites(sites_near(seed, area.expanded(kTerrainReach_m))) {
    const double reach = kTerrainReach_m + kRiverSway_m;
    const auto first =
        static_cast<std::int64_t>(std::floor((area.y0 - reach + kRiverSouth_m) / kRiverSpacing_m));
    const auto last =
        static_cast<std::int64_t>(std::floor((area.y1 + reach + kRiverSouth_m) / kRiverSpacing_m)) +
        1;
    for (auto m = first; m <= last; ++m)
        m_rivers.emplace_back(seed, m);
}

Terrain::Column Terrain::column(double x) const noexcept {
    Column column;
    column.x = x;
    for (const River& river : m_rivers) {
        if (column.count == static_cast<int>(column.rivers.size()))
            break;
        column.rivers[static_cast<std::size_t>(column.count++)] = river.at(x);
    }
    return column;
}

Terrain::Valley Terrain::valley(const Column& column, double y) const noexcept {
    // The two rivers that the point lies between: the valley floor passes from the level of one to
    // that of the other.
    std::size_t upper = 1;
    while (upper + 1 < static_cast<std::size_t>(column.count) && column.rivers[upper].centre_y <= y)
        ++upper;
    const RiverAtX& a = column.rivers[upper - 1];
    const RiverAtX& b = column.rivers[upper];
    const double to_a = std::abs(y - a.centre_y) * a.stretch;
    const double to_b = std::abs(b.centre_y - y) * b.stretch;
    const double part = (y - a.centre_y) / (b.centre_y - a.centre_y);
    const double level = lerp(a.level_m, b.level_m, smoothstep(0.25, 0.75, part));
    return {level, std::min(to_a, to_b), to_a <= to_b ? &a : &b};
}

double Terrain::hills(Vec2 p, const Valley& valley) const noexcept {
    const double rise = smoothstep(240.0, 1500.0, valley.distance_m);
    const double ridge =
        std::max(0.0, 0.62 + 0.95 * fractal_2d(m_seed, p.x / 1250.0, p.y / 1250.0, 4));
    const double high = 360.0 * rise * (0.45 * ridge + 0.55 * ridge * ridge);
    const double rough = fractal_2d(m_seed + 5, p.x / 70.0, p.y / 70.0, 3) * (0.5 + 9.0 * rise);
    const double roll = 1.1 * noise_2d(m_seed + 6, p.x / 170.0, p.y / 170.0);
    return valley.floor_m + 2.7 + 0.006 * std::min(valley.distance_m, 600.0) + roll + rough + high;
}

void Terrain::carve_lake(const Lake& lake, Vec2 p, TerrainSpot& spot) const noexcept {
    if (length(p - lake.centre) > lake.reach_m() + kShoreReach_m)
        return;
    const double off = lake.shore_distance(p);
    if (off < 0) {
        spot.ground_m = lake.level_m - 0.05 - lake.depth_m * smoothstep(0.0, 75.0, -off) -
                        0.06 * std::min(-off, 8.0);
    } else {
        const double shore = lake.level_m + 0.10 + 0.16 * std::min(off, 4.0) + 0.02 * off;
        spot.ground_m = lerp(shore, spot.ground_m, smoothstep(0.0, kShoreReach_m, off));
    }
    if (off < kNearWater_m) {
        spot.water_m = lake.level_m;
        spot.near_lake = true;
    }
}

void Terrain::carve_brook(const Brook& brook, Vec2 p, TerrainSpot& spot) const noexcept {
    const auto near = brook.nearest(p);
    if (near.distance_m > 60.0 || spot.ground_m < spot.water_m)
        return;  // a brook ends where other water begins
    spot.ground_m =
        carve_channel(spot.ground_m, near.distance_m, brook.half_width_m, 0.6, near.level_m);
    if (near.distance_m < brook.half_width_m + 1.0 && !spot.near_lake)
        spot.water_m = near.level_m;
}

TerrainSpot Terrain::at(const Column& column, double y) const noexcept {
    const Vec2 p{column.x, y};
    const Valley in = valley(column, y);
    TerrainSpot spot{hills(p, in), kNoWater, false};
    for (const Site& site : m_sites)
        for (const Hill& hill : site.hills)
            spot.ground_m += hill.height_m * bump(length(p - hill.centre) / hill.radius_m) *
                             (1.0 + 0.35 * noise_2d(site.seed, p.x / 90.0, p.y / 90.0));
    const double from_river = std::abs(y - in.nearest->centre_y) * in.nearest->stretch;
    spot.ground_m = carve_channel(spot.ground_m, from_river, in.nearest->half_width_m, 1.4,
                                  in.nearest->level_m);
    if (from_river < in.nearest->half_width_m + 1.0)
        spot.water_m = in.nearest->level_m;
    for (const Site& site : m_sites) {
        if (site.lake)
            carve_lake(*site.lake, p, spot);
        if (site.island && length(p - site.island->centre) < 90.0)
            spot.ground_m = std::max(spot.ground_m, island_height(*site.island, p, site.seed));
        if (site.castle && length(p - site.castle->centre) < 230.0)
            spot.ground_m = std::max(spot.ground_m, castle_height(*site.castle, p, site.seed));
        if (site.brook)
            carve_brook(*site.brook, p, spot);
    }
    return spot;
}

double Terrain::slope(Vec2 p) const noexcept {
    const Column here = column(p.x);
    const double dx = at({p.x + 2.0, p.y}).ground_m - at({p.x - 2.0, p.y}).ground_m;
    const double dy = at(here, p.y + 2.0).ground_m - at(here, p.y - 2.0).ground_m;
    return length({dx, dy}) / 4.0;
}

}  // namespace terravox::survey
