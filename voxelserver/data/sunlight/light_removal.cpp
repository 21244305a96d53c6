#include "voxelserver/data/sunlight/light_removal.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <optional>
#include <utility>

namespace terravox::sunlight {
namespace {

/// Combines `length` values that are `stride` apart, beginning at each.
template <class Combine>
std::vector<float> over_windows(std::vector<float> window, std::size_t stride, std::size_t length,
                                const Combine& combine) {
    std::vector<float> out(window.size(), 0.0F);
    std::vector<float> twice(window.size(), 0.0F);
    // `window` is over `size` values at each place. Beyond the end there is nothing.
    const auto combined = [&](const std::vector<float>& at, std::size_t by,
                              std::vector<float>& to) {
        for (std::size_t i = 0; i + by < window.size(); ++i)
            to[i] = combine(at[i], window[i + by]);
    };
    std::size_t done = 0;
    for (std::size_t size = 1; size <= length; size *= 2) {
        if ((length & size) != 0) {
            combined(out, done * stride, out);
            done += size;
        }
        combined(window, size * stride, twice);
        std::swap(window, twice);
    }
    return out;
}

}  // namespace

BrightnessAround::BrightnessAround(int width, int reach, const std::vector<BrightCell>& cells)
    : m_width(static_cast<std::size_t>(width)), m_reach(static_cast<std::size_t>(reach)) {
    Plane lit(cells.size(), 0.0F);
    Plane lit_count = lit;
    Plane shadow = lit;
    Plane shadow_count = lit;
    for (std::size_t i = 0; i < cells.size(); ++i)
        switch (cells[i].as) {
            case BrightCell::As::kLit:
                lit[i] = cells[i].light;
                lit_count[i] = 1;
                break;
            case BrightCell::As::kShadow:
                shadow[i] = cells[i].light;
                shadow_count[i] = 1;
                break;
            case BrightCell::As::kNothing: break;
        }
    const std::plus<float> sum;
    m_brightest_lit = over_squares(lit, [](float a, float b) { return std::max(a, b); });
    m_lit = over_squares(lit, sum);
    m_lit_count = over_squares(lit_count, sum);
    m_shadow = over_squares(shadow, sum);
    m_shadow_count = over_squares(shadow_count, sum);
}

BrightnessAround::Sums BrightnessAround::at(int x, int z) const noexcept {
    const std::size_t i =
        (static_cast<std::size_t>(z) - m_reach) * m_width + static_cast<std::size_t>(x) - m_reach;
    return {m_lit[i], m_brightest_lit[i], m_lit_count[i], m_shadow[i], m_shadow_count[i]};
}

template <class Combine>
BrightnessAround::Plane BrightnessAround::over_squares(const Plane& values,
                                                       const Combine& combine) const {
    const std::size_t side = 2 * m_reach + 1;
    return over_windows(over_windows(values, 1, side, combine), m_width, side, combine);
}

namespace {

/// Shares of the sun that are tried for a cell near the edge of a shadow.
constexpr std::size_t kShares = 8;
constexpr float measure_share(std::size_t at) noexcept {
    return static_cast<float>(at) / static_cast<float>(kShares - 1);
}
using ByShare = std::array<float, kShares>;

int measure_reach(const Scene& scene) {
    constexpr double kReach_m = 6;
    constexpr int kMin = 3;
    return std::clamp(static_cast<int>(std::lround(kReach_m / scene.cell_m)), kMin,
                      kMaxCompareReach);
}

}  // namespace

ReceivedLight::ReceivedLight(const Scene& scene, const SurfaceLight& surface,
                             const FlightLight& light)
    : m_scene(scene),
      m_surface(surface),
      m_light(light),
      m_reach(measure_reach(scene)),
      m_sky(luminance(light.sky)),
      m_veil(luminance(light.veil)),
      m_seen(scene.size()),
      m_root(scene.size()),
      m_albedo_root(scene.size()) {
    for (std::size_t i = 0; i < scene.size(); ++i) {
        if (scene.shown[i] == 0)
            continue;
        m_seen[i] = {brightness(i), BrightCell::As::kShadow};
        if (surface.lit[i] > 0.5F) {
            m_seen[i].as = BrightCell::As::kLit;
            m_seen[i].light /= m_sky * surface.sky_seen[i] + (1 - m_sky) * surface.facing[i];
        }
        const Light received = make_light(i, surface.lit[i] * surface.facing[i]);
        for (std::size_t c = 0; c < 3; ++c) {
            m_root[i][c] = std::sqrt(without_veil(scene.photo[i], light.veil)[c]);
            m_albedo_root[i][c] = m_root[i][c] / std::sqrt(received[c]);
        }
    }
}

float ReceivedLight::sun_at(int x, int z) const {
    constexpr float kNearlyAll = 0.95F;  // hardly darker than what it is compared with
    const std::size_t i = m_scene.index(x, z);
    float sun = m_surface.lit[i] * m_surface.facing[i];
    if (m_surface.edge[i] != 0) {
        if (const std::optional<float> lit = lit_by_photo(x, z))
            sun = *lit * m_surface.facing[i];
    } else if (sun >= kNearlyAll)
        return sun;
    return std::max(sun, min_sun(x, z));
}

Light ReceivedLight::make_light(std::size_t i, float sun) const noexcept {
    Light out{};
    for (std::size_t c = 0; c < 3; ++c)
        out[c] = m_light.sky[c] * m_surface.sky_seen[i] + (1 - m_light.sky[c]) * sun;
    return out;
}

// Each share of the sun gives the cell another albedo. The likelier one is that which occurs around
// the cell, away from edges of shadows: a density of kernels over these cells, in square roots of
// light, in which differences look alike. The kernel falls off slowly, as a cell may have
// an albedo of its own. Ref: Duda, Hart, Stork, "Pattern Classification", 2001, 4.3 (Parzen).
std::optional<float> ReceivedLight::lit_by_photo(int x, int z) const {
    constexpr float kDifference = 0.05F;  // the half width of the kernel
    constexpr float kOtherKind = 0.5F;    // its weight where what is there is of another kind
    constexpr float kSurface = 0.3F;      // how much the surface's own share counts
    const std::size_t i = m_scene.index(x, z);
    std::array<ByShare, 3> own{};
    for (std::size_t s = 0; s < kShares; ++s) {
        const Light received = make_light(i, measure_share(s) * m_surface.facing[i]);
        for (std::size_t c = 0; c < 3; ++c)
            own[c][s] = m_root[i][c] / std::sqrt(received[c]);
    }
    ByShare density{};
    bool any = false;
    for (int dz = -m_reach; dz <= m_reach; ++dz)
        for (int dx = -m_reach; dx <= m_reach; ++dx) {
            const std::size_t j = m_scene.index(x + dx, z + dz);
            if (m_surface.edge[j] != 0 || m_scene.shown[j] == 0)
                continue;
            any = true;
            const Light& there = m_albedo_root[j];
            const float weight = m_scene.kind[j] == m_scene.kind[i] ? 1 : kOtherKind;
            for (std::size_t s = 0; s < kShares; ++s) {
                float difference = 0;
                for (std::size_t c = 0; c < 3; ++c)
                    difference += (own[c][s] - there[c]) * (own[c][s] - there[c]);
                const float near = 1 / (1 + difference / (kDifference * kDifference));
                density[s] += weight * near * near;
            }
        }
    if (!any)
        return std::nullopt;
    // The mean over all shares, in which likely ones count much more.
    const float highest = *std::max_element(density.begin(), density.end());
    float sum = 0;
    float weights = 0;
    for (std::size_t s = 0; s < kShares; ++s) {
        const float off = measure_share(s) - m_surface.lit[i];
        const float likely = density[s] / (highest * (1 + kSurface * off * off));
        const float weight = likely * likely * likely * likely;
        sum += weight * measure_share(s);
        weights += weight;
    }
    return sum / weights;
}

// With less sun the cell would be brighter than anything around it: it does not lie in a shadow,
// whatever the surface says.
float ReceivedLight::min_sun(int x, int z) const {
    const std::size_t i = m_scene.index(x, z);
    const float limit = max_brightness(x, z, m_scene.kind[i]);
    if (!(limit > 0))
        return 0;
    return std::min((brightness(i) / limit - m_sky) / (1 - m_sky), 1.0F);
}

// How bright a cell of a kind may be in the sun; 0 = nothing is known. Beside grass only, it may be
// a road.
float ReceivedLight::max_brightness(int x, int z, Kind kind) const {
    constexpr float kAboveMean = 1.6F;
    constexpr float kEnough = 3;
    BrightnessAround::Sums near = around(kind, false).at(x, z);
    const auto nothing = [&] { return near.lit_count < kEnough && near.shadow_count < kEnough; };
    if (nothing())
        near = around(std::nullopt, false).at(x, z);
    if (nothing())
        near = around(std::nullopt, true).at(x, z);
    if (near.lit_count >= kEnough)
        return std::max(kAboveMean * near.lit / near.lit_count, near.brightest_lit);
    if (near.shadow_count < kEnough)
        return 0;
    // Where nothing lies in the sun, it follows from the shadow; but nothing is much brighter than
    // its kind is elsewhere.
    constexpr float kAboveTypical = 1.2F;
    const float lit = near.shadow / near.shadow_count / m_sky;
    const float typical = m_light.typical[static_cast<std::size_t>(kind)];
    return kAboveMean * (typical > 0 ? std::min(lit, kAboveTypical * typical) : lit);
}

/// @param kind nullopt = all
/// @param edges cells near the edge of a shadow count, too
const BrightnessAround& ReceivedLight::around(std::optional<Kind> kind, bool edges) const {
    auto& out = m_around[kind ? static_cast<std::size_t>(*kind) : kKinds + (edges ? 1 : 0)];
    if (!out) {
        std::vector<BrightCell> cells = m_seen;
        for (std::size_t i = 0; i < cells.size(); ++i)
            if ((m_surface.edge[i] != 0 && !edges) || (kind && m_scene.kind[i] != *kind))
                cells[i].as = BrightCell::As::kNothing;
        out.emplace(m_scene.width, m_reach, cells);
    }
    return *out;
}

float ReceivedLight::brightness(std::size_t i) const noexcept {
    return std::max(luminance(m_scene.photo[i]) - m_veil, 0.0F);
}

std::vector<Light> remove_light(const Surface& surface, const Scene& inner,
                                const LightField& light) {
    std::vector<Light> out(inner.size());
    std::optional<SurfaceLight> lit;
    std::optional<ReceivedLight> received;
    if (light.middle.sun) {
        lit = surface_light(surface, *light.middle.sun);
        received.emplace(inner, *lit, light.middle);
    }
    const auto along = [&](int at, int side) {
        return (static_cast<float>(at - kEdgeReach) + 0.5F) /
               static_cast<float>(side - 2 * kEdgeReach);
    };
    for (int z = kEdgeReach; z < inner.height - kEdgeReach; ++z)
        for (int x = kEdgeReach; x < inner.width - kEdgeReach; ++x) {
            const std::size_t i = inner.index(x, z);
            if (inner.shown[i] == 0)
                continue;
            const LightField::Levels levels =
                light.at(along(x, inner.width), along(z, inner.height));
            const Light seen = without_veil(inner.photo[i], levels.veil);
            const float sun = received ? received->sun_at(x, z) : 1;
            const float sky_seen = received ? lit->sky_seen[i] : 1;
            for (std::size_t c = 0; c < 3; ++c) {
                const float light_there = levels.sky[c] * sky_seen + (1 - levels.sky[c]) * sun;
                out[i][c] = levels.gain[c] * seen[c] / light_there;
            }
        }
    return out;
}

}  // namespace terravox::sunlight
