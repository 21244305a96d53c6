#include "voxelserver/sunlight/surface_light.hpp"

#include <algorithm>
#include <cmath>

namespace terravox::sunlight {
namespace {

/// Calls visit(x, z, i) for inner cells at least `border` from the margin: where they are in the
/// scene, and their index among inner cells.
template <class Visit>
void each_inner(const Scene& scene, int border, const Visit& visit) {
    const int width = scene.width - 2 * scene.margin;
    const int height = scene.height - 2 * scene.margin;
    for (int z = border; z < height - border; ++z)
        for (int x = border; x < width - border; ++x)
            visit(x + scene.margin, z + scene.margin, static_cast<std::size_t>(z * width + x));
}

void find_shadows(const Scene& scene, const Sun& sun, SurfaceLight& out) {
    constexpr double kEdge_m = 1;
    constexpr float kChange = 0.25F;
    constexpr float kVeryLow_m = -1e3F;  // a gap: nothing is known
    const std::vector<float> horizon = horizons(scene, sun.azimuth_deg);
    const Sunlit sunlit(sun.altitude_deg);
    each_inner(scene, 0, [&](int x, int z, std::size_t i) {
        if (scene.top_m[scene.index(x, z)] > kVeryLow_m)
            out.lit[i] = sunlit.share(horizon[scene.index(x, z)]);
    });
    const int reach =
        std::clamp(static_cast<int>(std::lround(kEdge_m / scene.cell_m)), 1, kSurfaceEdge);
    const int width = scene.width - 2 * scene.margin;
    each_inner(scene, reach, [&](int, int, std::size_t i) {
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
float facing_of(const Facing& facing, const Slope& slope) noexcept {
    constexpr float kMin = 0.15F;
    constexpr float kMax = 2.5F;
    return std::clamp(facing.on(slope), kMin, kMax);
}

/// The share of the sky that a slope sees.
float sky_seen_by(const Slope& slope) noexcept {
    return (1 + slope.up()) / 2;
}

void find_shading(const Scene& scene, const Sun& sun, SurfaceLight& out) {
    const std::vector<Slope> slopes = slopes_of(scene);
    const Facing facing(sun);
    each_inner(scene, 0, [&](int x, int z, std::size_t i) {
        const std::size_t there = scene.index(x, z);
        const Slope slope = shading_slope(slopes[there], scene.kind[there]);
        out.facing[i] = facing_of(facing, slope);
        out.sky_seen[i] = sky_seen_by(slope);
    });
}

}  // namespace

SurfaceLight surface_light(const Scene& scene, const Sun& sun) {
    const auto count = static_cast<std::size_t>(scene.width - 2 * scene.margin) *
                       static_cast<std::size_t>(scene.height - 2 * scene.margin);
    SurfaceLight out;
    out.lit.assign(count, 1.0F);
    out.edge.assign(count, 0);
    out.facing.assign(count, 1.0F);
    out.sky_seen.assign(count, 1.0F);
    find_shadows(scene, sun, out);
    find_shading(scene, sun, out);
    return out;
}

}  // namespace terravox::sunlight
