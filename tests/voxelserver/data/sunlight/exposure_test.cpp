// Made photographs of a road, a lawn, trees and houses with tiles: too bright, in haze, tinted, and
// as they should be.
#include "voxelserver/data/sunlight/exposure.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <vector>

#include "tests/catch.hpp"
#include "voxelserver/data/sunlight/sun.hpp"

using namespace terravox::sunlight;

namespace {

constexpr Light kAsphalt{0.125F, 0.12F, 0.115F};
constexpr Light kLawn{0.10F, 0.17F, 0.05F};
constexpr Light kCrown{0.06F, 0.12F, 0.04F};
constexpr Light kTiles{0.38F, 0.21F, 0.13F};
constexpr Light kDoor{0.012F, 0.014F, 0.013F};

constexpr int kSide = 140;
constexpr int kMargin = 20;

/// How a photograph differs from the truth.
struct Camera {
    Light gain{1, 1, 1};
    float veil = 0;
};

/// What stands at a cell. Roads cross lawns every 40 cells; a house and a tree stand between them.
struct Ground {
    Light albedo;
    float top_m = 0;
    Kind kind = Kind::kGround;
    Cover cover = Cover::kOther;
};
Ground ground_at(int x, int z) {
    const int east = x % 40;
    const int south = z % 40;
    if (east < 8)
        return {kAsphalt, 0, Kind::kGround, Cover::kAsphalt};
    if (east >= 12 && east < 24 && south >= 10 && south < 30) {
        const int to_ridge = std::abs(2 * (east - 12) - 11);
        return {kTiles, 6 - 0.25F * static_cast<float>(to_ridge), Kind::kRoof, Cover::kUnknown};
    }
    if (east >= 30 && east < 36 && south < 12)
        return {kCrown, 5, Kind::kPlant, Cover::kVegetation};
    if (east == 26 && south % 3 == 0)
        return {kDoor};
    return {kLawn};
}

/// @param told classes or echoes tell what is asphalt
Scene photographed(const Camera& camera, const std::optional<Sun>& sun, bool told = true) {
    Scene scene(kSide, kSide, kMargin, 1);
    if (told)
        scene.cover.resize(scene.size());
    std::uint32_t noise = 7;
    for (int z = 0; z < kSide; ++z)
        for (int x = 0; x < kSide; ++x) {
            const Ground here = ground_at(x, z);
            const std::size_t i = scene.index(x, z);
            scene.top_m[i] = here.top_m;
            scene.kind[i] = here.kind;
            if (told)
                scene.cover[i] = here.cover;
        }
    const std::vector<Slope> slopes = measure_slopes(scene);
    const std::vector<float> lit =
        sun ? lit_shares(scene, *sun) : std::vector<float>(scene.size(), 1.0F);
    const Light sky = sun ? Light{0.2F, 0.25F, 0.3F} : Light{1, 1, 1};
    for (int z = 0; z < kSide; ++z)
        for (int x = 0; x < kSide; ++x) {
            const std::size_t i = scene.index(x, z);
            const Ground here = ground_at(x, z);
            noise = noise * 1664525U + 1013904223U;
            const float grain = 0.9F + 0.2F * static_cast<float>(noise >> 8) / 16777216.0F;
            const float facing = sun ? Facing(*sun).on(slopes[i]) : 1;
            for (std::size_t c = 0; c < 3; ++c) {
                const float light = sky[c] + (1 - sky[c]) * lit[i] * facing;
                scene.photo[i][c] =
                    std::min(camera.gain[c] * grain * here.albedo[c] * light + camera.veil, 1.0F);
            }
            scene.shown[i] = 1;
        }
    return scene;
}

struct Developed {
    FlightLight light;
    Exposure exposure;
    FlightLight after;
};
Developed develop(const Scene& scene, const std::optional<Sun>& sun) {
    Developed out;
    out.light = measure_light(std::array{scene}, sun);
    out.exposure = find_exposure(find_evidence(std::array{scene}, out.light));
    out.after = exposed(out.light, out.exposure);
    return out;
}

/// Medians of what is flat and lies in the sun.
Light median_albedo(const Scene& scene, const std::optional<Sun>& sun, const FlightLight& light,
                    const Light& truth) {
    std::array<std::vector<float>, 3> values;
    const std::vector<float> lit =
        sun ? lit_shares(scene, *sun) : std::vector<float>(scene.size(), 1.0F);
    for (int z = kMargin; z < kSide - kMargin; ++z)
        for (int x = kMargin; x < kSide - kMargin; ++x) {
            const std::size_t i = scene.index(x, z);
            if (lit[i] < 1 || ground_at(x, z).albedo != truth)
                continue;
            const Light seen = without_veil(scene.photo[i], light.veil);
            for (std::size_t c = 0; c < 3; ++c)
                values[c].push_back(light.gain[c] * seen[c]);
        }
    Light out{};
    for (std::size_t c = 0; c < 3; ++c) {
        std::sort(values[c].begin(), values[c].end());
        out[c] = values[c][values[c].size() / 2];
    }
    return out;
}

Evidence evidence_of(float asphalt, float leaves, float tiles, std::uint32_t cells = 1000) {
    Evidence out;
    out.seen = {Sighting{{asphalt, asphalt, asphalt}, cells},
                Sighting{{0.6F * leaves, leaves, 0.5F * leaves}, cells},
                Sighting{{1.6F * tiles, tiles, 0.7F * tiles}, cells}};
    out.darkest = {0.01F, 0.01F, 0.01F};
    out.cells = 10 * cells;
    return out;
}

bool same_bits(const FlightLight& a, const FlightLight& b) {
    return a.sky == b.sky && a.veil == b.veil && a.gain == b.gain && a.typical == b.typical &&
           a.sun.has_value() == b.sun.has_value();
}

}  // namespace

TEST_CASE("photographs too bright, dark, veiled or tinted come back to the truth",
          "[sunlight][exposure]") {
    struct Case {
        const char* name;
        Camera camera;
    };
    const auto c = GENERATE(values<Case>({
        {"gain 2.5", {{2.5F, 2.5F, 2.5F}}},
        {"gain 4", {{4, 4, 4}}},
        {"gain 0.3", {{0.3F, 0.3F, 0.3F}}},
        {"veil", {{1, 1, 1}, 0.1F}},
        {"gain and veil", {{1.8F, 1.8F, 1.8F}, 0.08F}},
        {"warm", {{1.4F, 1, 0.7F}}},
        {"cold and bright", {{1.8F, 2.2F, 2.9F}}},
    }));
    const auto sun = GENERATE(values<std::optional<Sun>>({std::nullopt, Sun{150, 40}}));
    DYNAMIC_SECTION(c.name << (sun ? ", in the sun" : ", under a grey sky")) {
        const Scene scene = photographed(c.camera, sun);
        const Developed found = develop(scene, sun);
        CAPTURE(found.light.veil[1], found.light.gain[1], found.after.veil[1], found.after.gain[1]);
        for (const Light& truth : {kAsphalt, kLawn}) {
            const Light albedo = median_albedo(scene, sun, found.after, truth);
            CAPTURE(truth[1], albedo[0], albedo[1], albedo[2]);
            CHECK(albedo[1] > 0.75F * truth[1]);
            CHECK(albedo[1] < 1.33F * truth[1]);
            CHECK(albedo[0] / albedo[1] == Approx(truth[0] / truth[1]).epsilon(0.2));
            CHECK(albedo[2] / albedo[1] == Approx(truth[2] / truth[1]).margin(0.2));
        }
    }
}

TEST_CASE("a photograph that is right is left as it is, bit for bit", "[sunlight][exposure]") {
    const auto sun = GENERATE(values<std::optional<Sun>>({std::nullopt, Sun{150, 40}}));
    // A little brighter or darker is nature.
    const float gain = GENERATE(1.0F, 0.7F, 1.4F);
    const bool told = GENERATE(true, false);
    CAPTURE(sun.has_value(), gain, told);
    const Scene scene = photographed({{gain, gain, gain}}, sun, told);
    const Developed found = develop(scene, sun);
    CHECK(found.exposure == Exposure{});
    CHECK(same_bits(found.light, found.after));
}

TEST_CASE("where nothing tells asphalt from concrete, dark grey ground is taken for it",
          "[sunlight][exposure]") {
    const Scene scene = photographed({{2.5F, 2.5F, 2.5F}}, std::nullopt, false);
    const Developed found = develop(scene, std::nullopt);
    const Light albedo = median_albedo(scene, std::nullopt, found.after, kAsphalt);
    CHECK(albedo[1] > 0.75F * kAsphalt[1]);
    CHECK(albedo[1] < 1.33F * kAsphalt[1]);
}

TEST_CASE("wet soil that returns as little light as asphalt tells nothing",
          "[sunlight][exposure]") {
    Scene scene = photographed({}, std::nullopt);
    for (int z = 0; z < kSide; ++z)
        for (int x = 0; x < kSide; ++x)
            if (const Ground here = ground_at(x, z); here.cover == Cover::kAsphalt)
                scene.photo[scene.index(x, z)] =
                    z % 40 < 20 ? Light{0.34F, 0.25F, 0.16F} : kAsphalt;
            else if (here.kind == Kind::kGround)
                scene.photo[scene.index(x, z)] = {0.2F, 0.2F, 0.18F};
    for (int z = 0; z < kSide; ++z)
        for (int x = 0; x < kSide; ++x)
            if (z % 40 >= 20)
                scene.cover[scene.index(x, z)] = Cover::kOther;
    const Evidence found =
        find_evidence(std::array{scene}, measure_light(std::array{scene}, std::nullopt));
    CHECK(found.of(Known::kAsphalt).cells == 0);
    CHECK(found.of(Known::kTiles).cells > 100);
}

TEST_CASE("most of the known materials decide, and one alone does not", "[sunlight][exposure]") {
    // Montpellier: a pale road beside dark trees and tiles.
    CHECK(find_exposure(evidence_of(0.26F, 0.094F, 0.33F)) == Exposure{});
    // Dark tiles of the north.
    CHECK(find_exposure(evidence_of(0.12F, 0.2F, 0.08F)) == Exposure{});
    CHECK(find_exposure(evidence_of(0.40F, 0.28F, 0.53F)).gain[1] == Approx(0.45).epsilon(0.05));
    // Grass everywhere is no veil.
    Evidence grassy = evidence_of(0.12F, 0.25F, 0.2F);
    grassy.darkest = {0.018F, 0.12F, 0.024F};
    CHECK(find_exposure(grassy) == Exposure{});
    Evidence one = evidence_of(0.5F, 0, 0);
    one.seen[1] = one.seen[2] = {};
    CHECK(find_exposure(one) == Exposure{});
    Evidence contrary = evidence_of(0.5F, 0.02F, 0);
    contrary.seen[2] = {};
    CHECK(find_exposure(contrary) == Exposure{});
    Evidence few = evidence_of(0.5F, 0.6F, 0.7F, 10);
    CHECK(find_exposure(few) == Exposure{});
    CHECK(find_exposure({}) == Exposure{});
}

TEST_CASE("the photographs of a flight count together, each by what it shows",
          "[sunlight][exposure]") {
    const Evidence right = evidence_of(0.12F, 0.15F, 0.24F);
    const Evidence wide = evidence_of(0.40F, 0.40F, 0.50F, 3000);
    const Evidence odd = evidence_of(0.02F, 0.9F, 0.9F, 20);
    const Evidence together = pooled(std::array{right, wide, odd});
    CHECK(together.of(Known::kAsphalt).albedo[1] == 0.40F);
    CHECK(together.of(Known::kAsphalt).cells == 4020);
    CHECK(together.cells == 40200);
    const Evidence other_order = pooled(std::array{odd, right, wide});
    for (std::size_t k = 0; k < kKnown; ++k)
        CHECK(together.seen[k].albedo == other_order.seen[k].albedo);
    CHECK(pooled(std::array{right}).of(Known::kTiles).albedo == right.of(Known::kTiles).albedo);
}

TEST_CASE("a black point that is taken off makes shadows darker, too", "[sunlight][exposure]") {
    FlightLight light;
    light.sun = Sun{150, 40};
    light.sky = {0.4F, 0.4F, 0.4F};
    light.typical = {0, 0.3F, 0, 0.2F, 0};
    const FlightLight after = exposed(light, {{0.1F, 0.1F, 0.1F}, {0.5F, 0.5F, 0.5F}});
    CHECK(after.veil[1] == Approx(0.1));
    CHECK(after.gain[1] == Approx(0.5));
    CHECK(after.sky[1] == Approx((0.4 * 0.3 - 0.1) / (0.3 - 0.1)));
    CHECK(after.typical[1] == Approx(0.2));
    CHECK(after.typical[0] == 0);
}
