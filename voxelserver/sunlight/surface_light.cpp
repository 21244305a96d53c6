#include "voxelserver/sunlight/surface_light.hpp"

#include <algorithm>
#include <cmath>

namespace terravox::sunlight {
namespace {

template <class Visit>
void each_inner(const Scene& scene, int border, const Visit& visit) {
    for (int z = border; z < scene.height - border; ++z)
        for (int x = border; x < scene.width - border; ++x)
            visit(x, z);
}

void find_shadows(const Scene& scene, const Sun& sun, SurfaceLight& out) {
    constexpr double kEdge_m = 1;
    constexpr float kChange = 0.25F;
    constexpr float kVeryLow_m = -1e3F;  // a gap: nothing is known
    const std::vector<float> horizon = horizons(scene, sun.azimuth_deg);
    const Sunlit sunlit(sun.altitude_deg);
    each_inner(scene, scene.margin, [&](int x, int z) {
        const std::size_t i = scene.index(x, z);
        if (scene.top_m[i] > kVeryLow_m)
            out.lit[i] = sunlit.share(horizon[i]);
    });
    const int reach =
        std::clamp(static_cast<int>(std::lround(kEdge_m / scene.cell_m)), 1, kSurfaceEdge);
    each_inner(scene, scene.margin + reach, [&](int x, int z) {
        float low = 1;
        float high = 0;
        for (int dz = -reach; dz <= reach; ++dz)
            for (int dx = -reach; dx <= reach; ++dx) {
                const float lit = out.lit[scene.index(x + dx, z + dz)];
                low = std::min(low, lit);
                high = std::max(high, lit);
            }
        out.edge[scene.index(x, z)] = high - low > kChange ? 1 : 0;
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
    const float up = 1 / std::sqrt(1 + slope.east * slope.east + slope.south * slope.south);
    return (1 + up) / 2;
}

void find_shading(const Scene& scene, const Sun& sun, SurfaceLight& out) {
    const std::vector<Slope> slopes = slopes_of(scene);
    const Facing facing(sun);
    each_inner(scene, scene.margin, [&](int x, int z) {
        const std::size_t i = scene.index(x, z);
        const Slope slope = shading_slope(slopes[i], scene.kind[i]);
        out.facing[i] = facing_of(facing, slope);
        out.sky_seen[i] = sky_seen_by(slope);
    });
}

}  // namespace

SurfaceLight surface_light(const Scene& scene, const Sun& sun) {
    SurfaceLight out;
    out.lit.assign(scene.size(), 1.0F);
    out.edge.assign(scene.size(), 0);
    out.facing.assign(scene.size(), 1.0F);
    out.sky_seen.assign(scene.size(), 1.0F);
    find_shadows(scene, sun, out);
    find_shading(scene, sun, out);
    return out;
}

}  // namespace terravox::sunlight
