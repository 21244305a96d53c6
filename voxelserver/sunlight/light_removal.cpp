#include "voxelserver/sunlight/light_removal.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace terravox::sunlight {
namespace {

/// The share of the sun that each inner cell receives by the surface alone, and where that is not
/// certain.
struct Shadows {
    std::vector<float> lit;
    std::vector<std::uint8_t> edge;  ///< 1 = near the edge of a shadow
};

template <class Visit>
void each_inner(const Scene& scene, int border, const Visit& visit) {
    for (int z = border; z < scene.height - border; ++z)
        for (int x = border; x < scene.width - border; ++x)
            visit(x, z);
}

int cells_of(double metres, const Scene& scene, int low, int high) {
    return std::clamp(static_cast<int>(std::lround(metres / scene.cell_m)), low, high);
}

Shadows shadows_of(const Scene& scene, const Sun& sun) {
    constexpr double kEdge_m = 1;
    constexpr float kChange = 0.25F;
    constexpr float kVeryLow_m = -1e3F;  // a gap: nothing is known
    const std::vector<float> horizon = horizons(scene, sun.azimuth_deg);
    const Sunlit sunlit(sun.altitude_deg);
    Shadows out{std::vector<float>(scene.size(), 1.0F), std::vector<std::uint8_t>(scene.size())};
    each_inner(scene, scene.margin, [&](int x, int z) {
        const std::size_t i = scene.index(x, z);
        if (scene.top_m[i] > kVeryLow_m)
            out.lit[i] = sunlit.share(horizon[i]);
    });
    const int reach = cells_of(kEdge_m, scene, 1, 3);
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
    return out;
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
    constexpr float kLeast = 0.3F;
    constexpr float kMost = 1.8F;
    return std::clamp(facing.on(slope), kLeast, kMost);
}

/// The share of the sky that a slope sees.
float sky_seen_by(const Slope& slope) noexcept {
    const float up = 1 / std::sqrt(1 + slope.east * slope.east + slope.south * slope.south);
    return (1 + up) / 2;
}

/// How a cell is lit apart from shadows.
struct Shading {
    float facing = 1;    ///< Facing of its slope
    float sky_seen = 1;  ///< share of the sky that it sees
};

std::vector<Shading> shading_of(const Scene& scene, const Sun& sun) {
    const std::vector<Slope> slopes = slopes_of(scene);
    const Facing facing(sun);
    std::vector<Shading> out(scene.size());
    each_inner(scene, scene.margin, [&](int x, int z) {
        const std::size_t i = scene.index(x, z);
        const Slope slope = shading_slope(slopes[i], scene.kind[i]);
        out[i] = {facing_of(facing, slope), sky_seen_by(slope)};
    });
    return out;
}

/// What lies in the sun and in the shadow around a cell.
struct Around {
    float lit = 0;  ///< mean brightness, as on flat ground
    float lit_count = 0;
    float shadow = 0;  ///< mean brightness
    float shadow_count = 0;
};

class Edges {
public:
    Edges(const Scene& scene, const Shadows& shadows, const std::vector<Shading>& shading,
          const FlightLight& light)
        : m_scene(scene),
          m_shadows(shadows),
          m_shading(shading),
          m_reach(cells_of(5, scene, 3, kEdgeReach - 3)),
          m_sky(luminance(light.sky)),
          m_veil(luminance(light.veil)),
          m_typical(light.typical) {}

    /// The sun that a cell receives, over that of flat ground in the sun; by the photograph where
    /// the surface leaves it open.
    [[nodiscard]] float sun(int x, int z) const {
        constexpr float kNearlyAll = 0.95F;
        const std::size_t i = m_scene.index(x, z);
        const float facing = m_shading[i].facing;
        const float predicted = m_shadows.lit[i] * facing;
        if (m_shadows.edge[i] == 0 && predicted >= kNearlyAll)
            return predicted;
        const Around around = reference(x, z, m_scene.kind[i]);
        if (!(around.lit > 0))
            return predicted;
        const float value = brightness(i);
        const float in_sun = around.lit * (m_sky * m_shading[i].sky_seen + (1 - m_sky) * facing);
        constexpr float kLeastContrast = 1.15F;
        const bool decides = m_shadows.edge[i] != 0 && in_sun > kLeastContrast * around.shadow;
        const float share = (value - around.shadow) / (in_sun - around.shadow);
        const float sun = decides ? std::clamp(share, 0.0F, 1.0F) * facing : predicted;
        return std::max(sun, std::min(least(value, around.lit), 1.0F));
    }

private:
    [[nodiscard]] float brightness(std::size_t i) const noexcept {
        return std::max(luminance(m_scene.photo[i]) - m_veil, 0.0F);
    }

    /// The sun without which a cell would be much brighter than its surroundings: it does not lie
    /// in a shadow, whatever the surface says.
    [[nodiscard]] float least(float value, float lit_around) const noexcept {
        constexpr float kBrightest = 1.4F;
        return (value / (kBrightest * lit_around) - m_sky) / (1 - m_sky);
    }

    /// What cells of a kind would look like in the sun and in the shadow; `lit` is 0 where nothing
    /// is known.
    [[nodiscard]] Around reference(int x, int z, Kind kind) const {
        constexpr float kEnough = 3;
        const auto nothing = [](const Around& a) {
            return a.lit_count < kEnough && a.shadow_count < kEnough;
        };
        Around out = look_around(x, z, kind, false);
        if (nothing(out))
            out = look_around(x, z, std::nullopt, false);
        if (nothing(out))
            out = look_around(x, z, std::nullopt, true);
        // Where one of the two is not seen, it follows from the other; but nothing is much brighter
        // than its kind is elsewhere.
        if (out.lit_count < kEnough) {
            out.lit = out.shadow_count < kEnough ? 0 : out.shadow / m_sky;
            const float typical = m_typical[static_cast<std::size_t>(kind)];
            constexpr float kBrightest = 1.2F;
            if (typical > 0)
                out.lit = std::min(out.lit, kBrightest * typical);
        }
        if (out.shadow_count < kEnough)
            out.shadow = out.lit * m_sky;
        return out;
    }

    /// @param kind nullopt = all
    /// @param edges cells near the edge of a shadow count, too
    [[nodiscard]] Around look_around(int x, int z, std::optional<Kind> kind, bool edges) const {
        Around out;
        for (int dz = -m_reach; dz <= m_reach; ++dz)
            for (int dx = -m_reach; dx <= m_reach; ++dx) {
                const std::size_t j = m_scene.index(x + dx, z + dz);
                if ((m_shadows.edge[j] != 0 && !edges) || m_scene.shown[j] == 0 ||
                    (kind && m_scene.kind[j] != *kind))
                    continue;
                if (m_shadows.lit[j] > 0.5F) {
                    const Shading& shading = m_shading[j];
                    out.lit +=
                        brightness(j) / (m_sky * shading.sky_seen + (1 - m_sky) * shading.facing);
                    ++out.lit_count;
                } else {
                    out.shadow += brightness(j);
                    ++out.shadow_count;
                }
            }
        if (out.lit_count > 0)
            out.lit /= out.lit_count;
        if (out.shadow_count > 0)
            out.shadow /= out.shadow_count;
        return out;
    }

    const Scene& m_scene;
    const Shadows& m_shadows;
    const std::vector<Shading>& m_shading;
    int m_reach;
    float m_sky;
    float m_veil;
    std::array<float, kKinds> m_typical;
};

}  // namespace

std::vector<Light> remove_light(const Scene& scene, const FlightLight& light) {
    std::vector<Light> out(scene.size());
    const int border = scene.margin + kEdgeReach;
    const auto put = [&](std::size_t i, float sun, float sky_seen) {
        for (std::size_t c = 0; c < 3; ++c) {
            const float received = light.sky[c] * sky_seen + (1 - light.sky[c]) * sun;
            const float value = std::max(scene.photo[i][c] - light.veil[c], 0.0F);
            out[i][c] = light.gain[c] * value / received;
        }
    };
    if (!light.sun) {
        each_inner(scene, border, [&](int x, int z) { put(scene.index(x, z), 1, 1); });
        return out;
    }
    const Shadows shadows = shadows_of(scene, *light.sun);
    const std::vector<Shading> shading = shading_of(scene, *light.sun);
    const Edges edges(scene, shadows, shading, light);
    each_inner(scene, border, [&](int x, int z) {
        const std::size_t i = scene.index(x, z);
        if (scene.shown[i] == 0)
            return;
        put(i, edges.sun(x, z), shading[i].sky_seen);
    });
    return out;
}

}  // namespace terravox::sunlight
