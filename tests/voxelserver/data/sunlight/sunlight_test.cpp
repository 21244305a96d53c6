#include <algorithm>
#include <array>
#include <cmath>

#include "tests/catch.hpp"
#include "tests/voxelserver/data/sunlight/made_town.hpp"
#include "voxelserver/data/sunlight/light_removal.hpp"
#include "voxelserver/data/sunlight/sun.hpp"

using namespace terravox::sunlight;
using namespace terravox::sunlight::test;

namespace {

/// Calls visit(index, x, z) for the cells that have an albedo.
template <class Visit>
void each_result(const Scene& scene, const Visit& visit) {
    const int border = scene.margin + kEdgeReach;
    for (int z = border; z < scene.height - border; ++z)
        for (int x = border; x < scene.width - border; ++x)
            visit(scene.index(x, z), x, z);
}

/// The albedo of all cells of a scene; valid for those of each_result().
std::vector<Light> measure_albedo(const Scene& scene, const LightField& light) {
    Scene inner(inner_cells(scene));
    const auto each_inner = [&](const auto& visit) {
        for (int z = 0; z < inner.height; ++z)
            for (int x = 0; x < inner.width; ++x)
                visit(inner.index(x, z), scene.index(x + scene.margin, z + scene.margin));
    };
    each_inner([&](std::size_t to, std::size_t from) {
        inner.photo[to] = scene.photo[from];
        inner.shown[to] = scene.shown[from];
    });
    const std::vector<Light> albedo = remove_light(scene, inner, light);
    std::vector<Light> out(scene.size());
    each_inner([&](std::size_t from, std::size_t to) { out[to] = albedo[from]; });
    return out;
}

struct Errors {
    double before = 0;  ///< root of the mean squared error
    double after = 0;
};

Errors measure_errors(const MadeTown& town, const Scene& scene, const std::vector<Light>& albedo) {
    Errors out;
    double count = 0;
    each_result(scene, [&](std::size_t i, int x, int z) {
        const double truth = town.albedo(x, z);
        out.before += std::pow(scene.photo[i][1] - truth, 2);
        out.after += std::pow(albedo[i][1] - truth, 2);
        ++count;
    });
    return {std::sqrt(out.before / count), std::sqrt(out.after / count)};
}

/// Mean of the logarithm of what is in the sun over what is in the shadow, two cells to each side
/// of the edges of shadows, where both have the same albedo.
double contrast(const MadeTown& town, const Scene& scene, const Sun& sun,
                const std::vector<Light>& values) {
    double sum = 0;
    double count = 0;
    constexpr int kApart = 4;
    each_result(scene, [&](std::size_t, int x, int z) {
        if (x + kApart >= scene.width - scene.margin - kEdgeReach)
            return;
        const float a = town.sunlit(x, z, sun);
        const float b = town.sunlit(x + kApart, z, sun);
        const float same = std::abs(town.albedo(x, z) - town.albedo(x + kApart, z));
        if (std::abs(a - b) < 1 || same > 0)
            return;
        const double ratio = std::log(values[scene.index(x, z)][1]) -
                             std::log(values[scene.index(x + kApart, z)][1]);
        sum += a > b ? ratio : -ratio;
        ++count;
    });
    REQUIRE(count > 50);
    return sum / count;
}

double turn_between(double a, double b) {
    const double turn = std::abs(a - b);
    return std::min(turn, 360 - turn);
}

}  // namespace

TEST_CASE("shadows leave no edge, and albedo is much nearer to the truth than the photograph",
          "[sunlight][removal]") {
    const auto sun = GENERATE(Sun{150, 40}, Sun{235, 28});
    CAPTURE(sun.azimuth_deg, sun.altitude_deg);
    const MadeTown town(11);
    const Scene scene = town.photographed(sun, {});
    const FlightLight light = measure_light(std::array{scene}, sun);
    CHECK_THAT(light.sky[1], Catch::Matchers::WithinAbs(0.2, 0.05));
    const auto albedo = measure_albedo(scene, LightField(light));
    const Errors errors = measure_errors(town, scene, albedo);
    CAPTURE(errors.before, errors.after);
    CHECK(errors.after <= errors.before / 3);
    const double before = contrast(town, scene, sun, scene.photo);
    const double after = contrast(town, scene, sun, albedo);
    CAPTURE(before, after);
    CHECK(std::abs(after) <= 0.1 * before);
}

TEST_CASE("what haze took away comes back, as its veil tells", "[sunlight][levels]") {
    const Sun sun{150, 40};
    const MadeTown town(14);
    const auto mean_albedo = [&](const Weather& weather) {
        const Scene scene = town.photographed(sun, weather);
        const auto albedo =
            measure_albedo(scene, LightField(measure_light(std::array{scene}, sun)));
        double sum = 0;
        double count = 0;
        each_result(scene, [&](std::size_t i, int, int) {
            sum += static_cast<double>(albedo[i][1]);
            ++count;
        });
        return sum / count;
    };
    Weather clear;
    Weather hazy;
    hazy.veil = 0.04F;
    hazy.lost = 0.25F;
    // A quarter is lost, of which the veil tells most; it is measured carefully, so never too much.
    const double back = mean_albedo(hazy) / mean_albedo(clear);
    CAPTURE(back);
    CHECK(back > 0.85);
    CHECK(back < 1.02);
}

namespace {

constexpr Light kGrass{0.10F, 0.17F, 0.05F};
constexpr Light kPath{0.52F, 0.47F, 0.38F};
constexpr Light kSky{0.15F, 0.2F, 0.28F};
constexpr int kMiddle = 50;

/// Flat grass with a pale path from north to south, all in the sun.
Scene meadow() {
    Scene scene(100, 100, 20, 1);
    for (int z = 0; z < scene.height; ++z)
        for (int x = 0; x < scene.width; ++x) {
            const std::size_t i = scene.index(x, z);
            scene.top_m[i] = 0;
            scene.kind[i] = Kind::kGround;
            scene.photo[i] = std::abs(x - kMiddle) <= 2 ? kPath : kGrass;
            scene.shown[i] = 1;
        }
    return scene;
}

FlightLight light_from_the_east() {
    FlightLight out;
    out.sun = Sun{90, 45};
    out.sky = kSky;
    return out;
}

/// The greatest ratio of a cell's albedo to the truth, or of the truth to it.
float greatest_factor(const Scene& truth, const std::vector<Light>& albedo) {
    float out = 1;
    each_result(truth, [&](std::size_t i, int, int) {
        for (std::size_t c = 0; c < 3; ++c)
            out =
                std::max({out, albedo[i][c] / truth.photo[i][c], truth.photo[i][c] / albedo[i][c]});
    });
    return out;
}

}  // namespace

TEST_CASE("grass beside a pale path is not taken for a shadow on it", "[sunlight][removal]") {
    const Scene truth = meadow();
    Scene scene = truth;
    // Posts that the survey has met and the photograph does not show.
    for (int z = 32; z < 70; z += 6)
        for (const int x : {kMiddle - 5, kMiddle + 4})
            scene.top_m[scene.index(x, z)] = 3;
    CHECK(greatest_factor(truth, measure_albedo(scene, LightField(light_from_the_east()))) < 1.1F);
}

TEST_CASE("a shadow that lies a metre beside that of the surface is taken out of grass and path",
          "[sunlight][removal]") {
    const Scene truth = meadow();
    Scene scene = truth;
    // A hedge from north to south, 4 m high. The sun stands at 45 degrees in the east: its shadow
    // reaches 4 m to the west, and begins a cell further south in the photograph.
    constexpr int kHedge = kMiddle + 4;
    const auto beside_hedge = [](int z) { return z >= 39 && z < 59; };
    for (int z = 0; z < scene.height; ++z)
        for (int x = 0; x < scene.width; ++x) {
            const std::size_t i = scene.index(x, z);
            if (x == kHedge && beside_hedge(z))
                scene.top_m[i] = 4;
            if (x < kHedge && x >= kHedge - 4 && beside_hedge(z - 1))
                for (std::size_t c = 0; c < 3; ++c)
                    scene.photo[i][c] *= kSky[c];
        }
    CHECK(greatest_factor(truth, measure_albedo(scene, LightField(light_from_the_east()))) < 1.2F);
}

TEST_CASE("without a sun nothing is divided, and what has the light of nature stays as it is",
          "[sunlight][removal]") {
    const MadeTown town(13);
    const Scene scene = town.photographed({150, 40}, {1, 0, 0});
    const FlightLight light = measure_light(std::array{scene}, std::nullopt);
    CHECK(light.gain == Light{1, 1, 1});
    CHECK(light.veil == Light{});
    const auto albedo = measure_albedo(scene, LightField(light));
    bool same = true;
    each_result(scene,
                [&](std::size_t i, int, int) { same = same && albedo[i] == scene.photo[i]; });
    CHECK(same);
}

TEST_CASE("leaves that are too bright or too blue for leaves give exposure and white balance",
          "[sunlight][levels]") {
    Scene scene(100, 100, 20, 1);
    for (std::size_t i = 0; i < scene.size(); ++i) {
        scene.top_m[i] = 0;
        scene.kind[i] = Kind::kGround;
        scene.photo[i] = {0.60F, 0.70F, 0.60F};
        scene.shown[i] = 1;
    }
    const FlightLight light = measure_light(std::array{scene}, std::nullopt);
    CHECK(light.gain[1] < 0.6F);
    CHECK(light.gain[2] < light.gain[1]);
    CHECK(light.gain[0] == light.gain[1]);
}

TEST_CASE("gaps of a surface are filled from around, and wide ones cast no shadow",
          "[sunlight][scene]") {
    Scene scene(90, 90, 20, 1);
    for (int z = 0; z < 90; ++z)
        for (int x = 0; x < 30; ++x) {
            scene.top_m[scene.index(x, z)] = 5;
            scene.kind[scene.index(x, z)] = Kind::kRoof;
        }
    fill_gaps(scene);
    CHECK(scene.top_m[scene.index(30, 40)] == 5);
    CHECK(scene.kind[scene.index(31, 40)] == Kind::kRoof);
    CHECK(scene.kind[scene.index(32, 40)] == Kind::kUnknown);
    CHECK(scene.top_m[scene.index(29 + kGapReach, 40)] == 5);
    CHECK(scene.top_m[scene.index(30 + kGapReach, 40)] < -1000);
}

TEST_CASE("the sun is found from the shadows of houses, in haze and under clouds, too",
          "[sunlight][finder]") {
    struct Case {
        std::uint32_t seed;
        Sun sun;
        Weather weather;
    };
    const auto c = GENERATE(values<Case>({
        {1, {150, 40}, {0.2F, 0, 0}},
        {2, {203, 33}, {0.15F, 0, 0}},
        {3, {95, 25}, {0.25F, 0, 0}},
        {4, {268, 52}, {0.2F, 0, 0}},
        {7, {162, 49}, {0.45F, 0.1F, 0}},
        {9, {140, 36}, {0.4F, 0.05F, 0.5F}},
    }));
    DYNAMIC_SECTION("town " << c.seed << ", sun " << c.sun.azimuth_deg << ", "
                            << c.sun.altitude_deg) {
        const std::array scenes{MadeTown(c.seed).photographed(c.sun, c.weather)};
        const auto found = find_sun(scenes);
        REQUIRE(found);
        CAPTURE(found->sun.azimuth_deg, found->sun.altitude_deg, found->correlation, found->margin);
        CHECK(turn_between(found->sun.azimuth_deg, c.sun.azimuth_deg) <= 3);
        CHECK(std::abs(found->sun.altitude_deg - c.sun.altitude_deg) <= 3);
        CHECK(is_certain(*found));
    }
}

TEST_CASE("no sun is certain where nothing casts a shadow, or a photograph shows another place",
          "[sunlight][finder]") {
    const MadeTown here(1);
    const MadeTown elsewhere(2);
    SECTION("no shadow") {
        const std::array scenes{here.photographed({150, 40}, {1, 0, 0})};
        CHECK_FALSE(is_certain(find_sun(scenes).value()));
    }
    SECTION("another place") {
        Scene scene = here.photographed({150, 40}, {});
        scene.photo = elsewhere.photographed({150, 40}, {}).photo;
        const std::array scenes{scene};
        const SunEstimate found = find_sun(scenes).value();
        CAPTURE(found.correlation, found.margin);
        CHECK_FALSE(is_certain(found));
    }
}

TEST_CASE("nothing is estimated from a few cells", "[sunlight][finder]") {
    Scene scene(80, 80, 30, 1);
    fill_gaps(scene);
    CHECK_FALSE(find_sun(std::array{scene}));
    CHECK_FALSE(find_sun({}));
}
