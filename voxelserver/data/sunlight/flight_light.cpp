#include "voxelserver/data/sunlight/flight_light.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/util/det_math.hpp"

namespace terravox::sunlight {
namespace {

float percentile(std::vector<float>& values, double share) {
    const auto at = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), values.begin() + at, values.end());
    return values[static_cast<std::size_t>(at)];
}

template <class Visit>
void each_shown(const Scene& scene, const Visit& visit) {
    for (int z = scene.margin; z < scene.height - scene.margin; ++z)
        for (int x = scene.margin; x < scene.width - scene.margin; ++x)
            if (const std::size_t i = scene.index(x, z); scene.shown[i] != 0)
                visit(i, x, z);
}

/// The darkest that is seen, beyond what leaves in the shadow return.
Light measure_veil(std::span<const Scene> scenes) {
    constexpr double kDarkest = 0.003;
    constexpr float kDarkLeaves = 0.012F;
    constexpr float kThickest = 0.15F;
    constexpr float kPart = 0.7F;  // carefully: too thick a veil makes leaves black
    Light out{};
    for (std::size_t c = 0; c < 3; ++c) {
        std::vector<float> values;
        for (const Scene& scene : scenes)
            each_shown(scene,
                       [&](std::size_t i, int, int) { values.push_back(scene.photo[i][c]); });
        if (!values.empty())
            out[c] =
                std::clamp(kPart * (percentile(values, kDarkest) - kDarkLeaves), 0.0F, kThickest);
    }
    return out;
}

/// What brings the light back that the air between took away: the brighter its veil, the more of
/// it. Seen from above, the veil of thin haze is 0.12 to 0.19 of the share of the light that is
/// lost on both ways: single scattering after Henyey and Greenstein with an asymmetry of 0.65, as
/// of continental aerosol, 95 to 100 % of it scattered, the sun 30 to 60 degrees high. Ref: Hansen
/// and Travis, "Light scattering in planetary atmospheres", Space Sci. Rev. 16, 1974.
float clear_air_gain(const Light& veil) noexcept {
    constexpr float kVeilPerLoss = 0.15F;
    constexpr float kMaxLoss = 0.35F;  // in thicker air there are no shadows to find
    return 1 / (1 - std::min(luminance(veil) / kVeilPerLoss, kMaxLoss));
}

/// Sums over the cells of a tile that certainly are lit, or certainly lie in a shadow.
struct Tile {
    Light lit{};
    Light shadow{};
    int lit_count = 0;
    int shadow_count = 0;
};

/// Whether all cells up to `reach` away have the same share of the sun as the middle.
bool is_certain(const Scene& scene, const std::vector<float>& lit, int x, int z, int reach) {
    constexpr float kSame = 0.02F;
    for (int dz = -reach; dz <= reach; ++dz)
        for (int dx = -reach; dx <= reach; ++dx)
            if (std::abs(lit[scene.index(x + dx, z + dz)] - lit[scene.index(x, z)]) > kSame)
                return false;
    return true;
}

/// Sums of ground in tiles, and of each kind in all scenes: of cells away from edges of shadows,
/// and of all cells that are fully lit or in full shadow.
struct Contrasts {
    std::vector<Tile> ground;
    std::array<Tile, kKinds> inner;
    std::array<Tile, kKinds> whole;
};

void add(const Light& value, bool in_sun, Tile& tile) noexcept {
    for (std::size_t c = 0; c < 3; ++c)
        (in_sun ? tile.lit : tile.shadow)[c] += value[c];
    ++(in_sun ? tile.lit_count : tile.shadow_count);
}

void add_contrasts(const Scene& scene, const Sun& sun, const Light& veil, Contrasts& out) {
    constexpr double kTile_m = 16;
    const int side = std::max(4, static_cast<int>(std::lround(kTile_m / scene.cell_m)));
    const int across = (scene.width + side - 1) / side;
    const int down = (scene.height + side - 1) / side;
    const std::size_t first = out.ground.size();
    out.ground.resize(first + static_cast<std::size_t>(across) * static_cast<std::size_t>(down));
    const std::vector<float> lit = lit_shares(scene, sun);
    each_shown(scene, [&](std::size_t i, int x, int z) {
        constexpr float kPartly = 0.02F;
        if (lit[i] > kPartly && lit[i] < 1 - kPartly)
            return;
        const bool in_sun = lit[i] > 0.5F;
        const Light value = without_veil(scene.photo[i], veil);
        add(value, in_sun, out.whole[static_cast<std::size_t>(scene.kind[i])]);
        if (is_certain(scene, lit, x, z, 1))
            add(value, in_sun, out.inner[static_cast<std::size_t>(scene.kind[i])]);
        if (scene.kind[i] == Kind::kGround && is_certain(scene, lit, x, z, 2))
            add(value, in_sun,
                out.ground[first + static_cast<std::size_t>((z / side) * across + x / side)]);
    });
}

/// Shadow over sun; nullopt where one of them has fewer than `least` cells, or is black.
std::optional<Light> measure_ratio(const Tile& tile, int least) {
    if (tile.lit_count < least || tile.shadow_count < least)
        return std::nullopt;
    Light out{};
    for (std::size_t c = 0; c < 3; ++c) {
        if (!(tile.lit[c] > 0))
            return std::nullopt;
        out[c] = tile.shadow[c] / static_cast<float>(tile.shadow_count) /
                 (tile.lit[c] / static_cast<float>(tile.lit_count));
    }
    return out;
}

/// The ratio of ground, else of roofs, else of plants, away from edges if possible.
std::optional<Light> whole_ratio(const Contrasts& contrasts) {
    constexpr int kMinCells = 24;
    for (const auto* sums : {&contrasts.inner, &contrasts.whole})
        for (const Kind kind : {Kind::kGround, Kind::kRoof, Kind::kPlant})
            if (const auto ratio =
                    measure_ratio((*sums)[static_cast<std::size_t>(kind)], kMinCells))
                return ratio;
    return std::nullopt;
}

/// The median over tiles in which ground lies in the sun and in the shadow; where these are few,
/// the ratio of what lies in the sun and in the shadow anywhere.
Light find_sky(std::span<const Scene> scenes, const Sun& sun, const Light& veil) {
    constexpr int kMinCells = 6;
    constexpr std::size_t kMinTiles = 4;
    constexpr float kDarkest = 0.08F;
    Contrasts contrasts;
    for (const Scene& scene : scenes)
        add_contrasts(scene, sun, veil, contrasts);
    std::array<std::vector<float>, 3> ratios;
    for (const Tile& tile : contrasts.ground)
        if (const auto ratio = measure_ratio(tile, kMinCells))
            for (std::size_t c = 0; c < 3; ++c)
                ratios[c].push_back((*ratio)[c]);
    Light out{1, 1, 1};
    if (ratios[0].size() >= kMinTiles) {
        for (std::size_t c = 0; c < 3; ++c)
            out[c] = percentile(ratios[c], 0.5);
    } else
        out = whole_ratio(contrasts).value_or(out);
    for (float& value : out)
        value = std::clamp(value, kDarkest, 1.0F);
    return out;
}

/// Median luminance in the sun, by kind.
std::array<float, kKinds> find_typical(std::span<const Scene> scenes, const Sun& sun,
                                       const Light& veil) {
    constexpr float kLit = 0.95F;
    std::array<std::vector<float>, kKinds> values;
    for (const Scene& scene : scenes) {
        const std::vector<float> lit = lit_shares(scene, sun);
        each_shown(scene, [&](std::size_t i, int, int) {
            if (lit[i] > kLit)
                values[static_cast<std::size_t>(scene.kind[i])].push_back(
                    luminance(without_veil(scene.photo[i], veil)));
        });
    }
    std::array<float, kKinds> out{};
    for (std::size_t k = 0; k < kKinds; ++k)
        if (!values[k].empty())
            out[k] = percentile(values[k], 0.5);
    return out;
}

/// What median values of a material are possible.
struct Range {
    float low;
    float high;
    /// The factor that brings a value into the range.
    [[nodiscard]] float factor(float value) const noexcept {
        return std::clamp(value, low, high) / value;
    }
};

/// Leaves and grass. Brightness is generous: photographs are made bright, and species differ.
/// Ref: reflectances of vegetation in the USGS spectral library, version 7.
constexpr Range kLuminance{0.045F, 0.32F};
constexpr Range kRedOverGreen{0.45F, 0.95F};
constexpr Range kBlueOverGreen{0.20F, 0.75F};

}  // namespace

Light without_veil(const Light& seen, const Light& veil) noexcept {
    Light out{};
    for (std::size_t c = 0; c < 3; ++c)
        out[c] = std::max(seen[c] - veil[c], 0.0F);
    return out;
}

bool is_leaf_green(const Light& seen) noexcept {
    return seen[1] > 1.03F * seen[0] && seen[1] > 1.1F * seen[2] && seen[0] > 0.25F * seen[1] &&
           seen[2] > 0.1F * seen[1];
}

FlightLight measure_light(std::span<const Scene> scenes, const std::optional<Sun>& sun) {
    FlightLight out;
    out.sun = sun;
    if (sun) {
        out.veil = measure_veil(scenes);
        out.sky = find_sky(scenes, *sun, out.veil);
        out.typical = find_typical(scenes, *sun, out.veil);
    }
    const float air = clear_air_gain(out.veil);
    out.gain = {air, air, air};
    // Crowns and grass: what is greenest among plants and ground.
    std::array<std::vector<float>, 3> green;
    for (const Scene& scene : scenes)
        each_shown(scene, [&](std::size_t i, int, int) {
            const Light seen = without_veil(scene.photo[i], out.veil);
            const bool grows = scene.kind[i] == Kind::kPlant || scene.kind[i] == Kind::kGround;
            if (grows && is_leaf_green(seen))
                for (std::size_t c = 0; c < 3; ++c)
                    green[c].push_back(air * seen[c]);
        });
    constexpr std::size_t kMinCells = 200;
    if (green[0].size() < kMinCells)
        return out;
    // The upper quartile: mostly in the sun.
    constexpr double kSunlit = 0.75;
    Light value{};
    for (std::size_t c = 0; c < 3; ++c)
        value[c] = std::max(percentile(green[c], kSunlit), 1e-3F);
    const float exposure = air * kLuminance.factor(luminance(value));
    out.gain = {exposure * kRedOverGreen.factor(value[0] / value[1]), exposure,
                exposure * kBlueOverGreen.factor(value[2] / value[1])};
    return out;
}

namespace {

constexpr double kRadian_deg = 180 / det::kPi;

/// A direction as a unit vector: east, north, up.
using Direction = std::array<double, 3>;

Direction to_direction(const Sun& sun) noexcept {
    const double level = det::cos(sun.altitude_deg / kRadian_deg);
    return {level * det::sin(sun.azimuth_deg / kRadian_deg),
            level * det::cos(sun.azimuth_deg / kRadian_deg),
            det::sin(sun.altitude_deg / kRadian_deg)};
}

Sun make_sun(const Direction& to) noexcept {
    const double level = std::sqrt(to[0] * to[0] + to[1] * to[1]);
    const double azimuth_deg = det::atan2(to[0], to[1]) * kRadian_deg;
    return {azimuth_deg < 0 ? azimuth_deg + 360 : azimuth_deg,
            det::atan2(to[2], level) * kRadian_deg};
}

LightField::Levels make_levels(const FlightLight& light) noexcept {
    return {light.sky, light.veil, light.gain};
}

}  // namespace

bool is_same_flight(const Sun& a, const Sun& b) noexcept {
    constexpr double kApart_deg = 5;
    const Direction to_a = to_direction(a);
    const Direction to_b = to_direction(b);
    return to_a[0] * to_b[0] + to_a[1] * to_b[1] + to_a[2] * to_b[2] >=
           det::cos(kApart_deg / kRadian_deg);
}

FlightLight blended(std::span<const WeightedLight> lights) {
    if (lights.size() == 1)
        return lights.front().light;
    FlightLight out;
    out.sky = out.veil = out.gain = {};
    Direction sun{};
    float sum = 0;
    std::array<float, kKinds> known{};
    for (const WeightedLight& one : lights) {
        const Direction to = to_direction(*one.light.sun);
        for (std::size_t c = 0; c < 3; ++c) {
            sun[c] += static_cast<double>(one.weight) * to[c];
            out.sky[c] += one.weight * one.light.sky[c];
            out.veil[c] += one.weight * one.light.veil[c];
            out.gain[c] += one.weight * one.light.gain[c];
        }
        sum += one.weight;
        for (std::size_t k = 0; k < kKinds; ++k)
            if (one.light.typical[k] > 0) {
                out.typical[k] += one.weight * one.light.typical[k];
                known[k] += one.weight;
            }
    }
    for (std::size_t c = 0; c < 3; ++c) {
        out.sky[c] /= sum;
        out.veil[c] /= sum;
        out.gain[c] /= sum;
    }
    for (std::size_t k = 0; k < kKinds; ++k)
        if (known[k] > 0)
            out.typical[k] /= known[k];
    out.sun = make_sun(sun);
    return out;
}

LightField::LightField(const FlightLight& light) noexcept
    : middle(light),
      corners{make_levels(light), make_levels(light), make_levels(light), make_levels(light)} {}

LightField::LightField(const FlightLight& of_middle,
                       const std::array<FlightLight, 4>& of_corners) noexcept
    : middle(of_middle),
      corners{make_levels(of_corners[0]), make_levels(of_corners[1]), make_levels(of_corners[2]),
              make_levels(of_corners[3])} {}

LightField::Levels LightField::at(float east, float south) const noexcept {
    const auto mix = [&](const Light Levels::* of) {
        Light out{};
        for (std::size_t c = 0; c < 3; ++c) {
            const auto along = [&](std::size_t west) {
                const float from = (corners[west].*of)[c];
                return from + east * ((corners[west + 1].*of)[c] - from);
            };
            const float north = along(0);
            out[c] = north + south * (along(2) - north);
        }
        return out;
    };
    return {mix(&Levels::sky), mix(&Levels::veil), mix(&Levels::gain)};
}

}  // namespace terravox::sunlight
