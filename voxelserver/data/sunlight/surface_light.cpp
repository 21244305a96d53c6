#include <algorithm>
#include <cmath>

#include "common/util/det_math.hpp"
#include "voxelserver/data/sunlight/sun.hpp"

namespace terravox::sunlight {
namespace {

constexpr double kDegree = det::kPi / 180;

}  // namespace

std::vector<float> horizons(const Surface& surface, double azimuth_deg) {
    const double east = det::sin(azimuth_deg * kDegree);
    const double south = -det::cos(azimuth_deg * kDegree);
    std::vector<float> out(surface.size(), 0.0F);
    struct Step {
        int dx;
        int dz;
        float per_run;
    };
    std::vector<Step> steps;
    for (int step = 1; step <= surface.margin; ++step)
        steps.push_back({static_cast<int>(std::floor(step * east + 0.5)),
                         static_cast<int>(std::floor(step * south + 0.5)),
                         static_cast<float>(1 / (step * surface.cell_m))});
    // Step by step over a row: its cells are independent of each other, and stay in the cache.
    const int count = surface.width - 2 * surface.margin;
    for (int z = surface.margin; z < surface.height - surface.margin; ++z)
        for (const Step& step : steps) {
            const float* own = &surface.top_m[surface.index(surface.margin, z)];
            const float* there =
                &surface.top_m[surface.index(surface.margin + step.dx, z + step.dz)];
            float* horizon = &out[surface.index(surface.margin, z)];
            for (int x = 0; x < count; ++x)
                horizon[x] = std::max(horizon[x], (there[x] - own[x]) * step.per_run);
        }
    return out;
}

Sunlit::Sunlit(double altitude_deg) noexcept {
    constexpr double kHalfSoft_deg = 1;
    const double rise = det::tan(altitude_deg * kDegree);
    m_rise = static_cast<float>(rise);
    m_sharpness = static_cast<float>(0.5 / (kHalfSoft_deg * kDegree * (1 + rise * rise)));
}

std::vector<float> lit_shares(const Surface& surface, const Sun& sun) {
    std::vector<float> lit = horizons(surface, sun.azimuth_deg);
    const Sunlit sunlit(sun.altitude_deg);
    for (float& value : lit)
        value = sunlit.share(value);
    return lit;
}

Facing::Facing(const Sun& sun) noexcept {
    const double rise = det::tan(sun.altitude_deg * kDegree);
    m_east = static_cast<float>(det::sin(sun.azimuth_deg * kDegree) / rise);
    m_south = static_cast<float>(-det::cos(sun.azimuth_deg * kDegree) / rise);
}

namespace {

/// Calls visit(x, z, i) for inner cells at least `border` from the margin: where they are in the
/// surface, and their index among inner cells.
template <class Visit>
void each_inner(const Surface& surface, int border, const Visit& visit) {
    const int width = surface.width - 2 * surface.margin;
    const int height = surface.height - 2 * surface.margin;
    for (int z = border; z < height - border; ++z)
        for (int x = border; x < width - border; ++x)
            visit(x + surface.margin, z + surface.margin, static_cast<std::size_t>(z * width + x));
}

void find_shadows(const Surface& surface, const Sun& sun, SurfaceLight& out) {
    constexpr double kEdge_m = 1;
    constexpr float kChange = 0.25F;
    constexpr float kVeryLow_m = -1e3F;  // a gap: nothing is known
    const std::vector<float> horizon = horizons(surface, sun.azimuth_deg);
    const Sunlit sunlit(sun.altitude_deg);
    each_inner(surface, 0, [&](int x, int z, std::size_t i) {
        if (surface.top_m[surface.index(x, z)] > kVeryLow_m)
            out.lit[i] = sunlit.share(horizon[surface.index(x, z)]);
    });
    const int reach =
        std::clamp(static_cast<int>(std::lround(kEdge_m / surface.cell_m)), 1, kSurfaceEdge);
    const int width = surface.width - 2 * surface.margin;
    each_inner(surface, reach, [&](int, int, std::size_t i) {
        float low = 1;
        float high = 0;
        for (int dz = -reach; dz <= reach; ++dz)
            for (int dx = -reach; dx <= reach; ++dx) {
                const float lit = out.lit[i + static_cast<std::size_t>(dz * width + dx)];
                low = std::min(low, lit);
                high = std::max(high, lit);
            }
        out.edge[i] = high - low > kChange ? 1 : 0;
    });
}

/// The slope by which a cell is shaded: leaves point everywhere, so that a crown is shaded as a
/// flatter one would be.
Slope shading_slope(const Slope& slope, Kind kind) noexcept {
    constexpr float kLeaves = 0.4F;
    if (kind == Kind::kWater || kind == Kind::kUnknown)
        return {};
    return kind == Kind::kPlant ? Slope{kLeaves * slope.east, kLeaves * slope.south} : slope;
}

/// Limited, as slopes are not exact.
float find_facing(const Facing& facing, const Slope& slope) noexcept {
    constexpr float kMin = 0.15F;
    constexpr float kMax = 2.5F;
    return std::clamp(facing.on(slope), kMin, kMax);
}

/// The share of the sky that a slope sees.
float sky_seen_by(const Slope& slope) noexcept {
    return (1 + slope.up()) / 2;
}

void find_shading(const Surface& surface, const Sun& sun, SurfaceLight& out) {
    // Slopes need two cells around; the margin may be many times as large as the inner part.
    constexpr int kAround = 2;
    const Surface near = inner_cells(surface, std::min(surface.margin, kAround));
    const std::vector<Slope> slopes = measure_slopes(near);
    const Facing facing(sun);
    each_inner(near, 0, [&](int x, int z, std::size_t i) {
        const std::size_t there = near.index(x, z);
        const Slope slope = shading_slope(slopes[there], near.kind[there]);
        out.facing[i] = find_facing(facing, slope);
        out.sky_seen[i] = sky_seen_by(slope);
    });
}

}  // namespace

SurfaceLight surface_light(const Surface& surface, const Sun& sun) {
    const auto count = static_cast<std::size_t>(surface.width - 2 * surface.margin) *
                       static_cast<std::size_t>(surface.height - 2 * surface.margin);
    SurfaceLight out;
    out.lit.assign(count, 1.0F);
    out.edge.assign(count, 0);
    out.facing.assign(count, 1.0F);
    out.sky_seen.assign(count, 1.0F);
    find_shadows(surface, sun, out);
    find_shading(surface, sun, out);
    return out;
}

}  // namespace terravox::sunlight
