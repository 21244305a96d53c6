#include "raytracer/core/material/material_table.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include "tests/catch.hpp"

using namespace terravox;
using voxel::Material;

namespace {

const material::MaterialTable& table() {
    static const material::MaterialTable made(std::filesystem::path(TERRAVOX_SOURCE_DIR) /
                                              "config/materials.toml");
    return made;
}

material::FacePoint random_point(std::mt19937_64& random) {
    const auto below = [&](std::uint64_t n) { return static_cast<int>(random() % n); };
    material::FacePoint at;
    const auto coordinate = [&] {
        return static_cast<std::int32_t>(static_cast<std::uint32_t>(random())) >> below(16);
    };
    at.voxel = {coordinate(), coordinate(), coordinate()};
    at.level = below(3) == 0 ? below(21) : 0;
    at.face = static_cast<core::Face>(below(6));
    at.u = static_cast<double>(random() >> 11) * 0x1.0p-53;
    at.v = static_cast<double>(random() >> 11) * 0x1.0p-53;
    at.footprint = below(4) == 0 ? 0 : std::ldexp(at.u + 0.5, below(20) - 10);
    at.around = static_cast<std::uint8_t>(random());
    at.voxel_m = std::ldexp(0.01 + at.v, below(12) - 4);
    at.night = below(2) == 0;
    return at;
}

bool within(float v, float low, float high) {
    return v >= low && v <= high;
}

// The mean of what is drawn on walls, over random places, to pixels of `footprint` voxels.
struct WallMean {
    double share = 0;
    double gloss = 0;
    double emission = 0;
    double red = 0;
};
WallMean wall_mean(double voxel_m, double footprint, int level, int count) {
    std::mt19937_64 random(17);
    WallMean sum;
    for (int i = 0; i < count; ++i) {
        material::FacePoint at = random_point(random);
        at.face = i % 2 == 0 ? core::Face::kSouth : core::Face::kWest;
        at.voxel = {at.voxel.x % 50'000, at.voxel.y % 50'000, at.voxel.z % 50'000};
        at.footprint = footprint;
        at.level = level;
        at.voxel_m = voxel_m;
        at.night = true;
        const material::Texel t = table().texel(Material::kWall, at);
        sum.share += static_cast<double>(t.own_share);
        sum.gloss += static_cast<double>(t.gloss);
        sum.emission += static_cast<double>(t.emission);
        sum.red += static_cast<double>(t.own.r * t.own_share);
    }
    return {sum.share / count, sum.gloss / count, sum.emission / count, sum.red / count};
}

}  // namespace

TEST_CASE("at any point, a texel's fields are in their ranges and reproducible",
          "[raytracer][material]") {
    std::mt19937_64 random(5);
    for (int i = 0; i < 200'000; ++i) {
        const auto material = static_cast<Material>(i % 30);  // some beyond the last
        const material::FacePoint at = random_point(random);
        const material::Texel t = table().texel(material, at);
        const material::Texel again = table().texel(material, at);
        bool good = within(t.tilt[0], -0.2f, 0.2f) && within(t.tilt[1], -0.2f, 0.2f);
        for (const float ratio : {t.ratio.r, t.ratio.g, t.ratio.b})
            good = good && within(ratio, 0.02f, 4);
        for (const float own : {t.own.r, t.own.g, t.own.b})
            good = good && within(own, 0, 4);
        for (const float share : {t.own_share, t.opacity, t.emission, t.gloss})
            good = good && within(share, 0, 1);
        const bool same = t.ratio.r == again.ratio.r && t.own.g == again.own.g &&
                          t.own_share == again.own_share && t.opacity == again.opacity &&
                          t.emission == again.emission && t.tilt == again.tilt;
        if (!good || !same) {
            INFO(voxel::material_name(material)
                 << " voxel " << at.voxel.x << ' ' << at.voxel.y << ' ' << at.voxel.z << " level "
                 << at.level << " face " << static_cast<int>(at.face) << " u " << at.u << " v "
                 << at.v << " footprint " << at.footprint << " around " << int{at.around}
                 << " voxel_m " << at.voxel_m);
            CHECK(good);
            CHECK(same);
            return;
        }
    }
}

TEST_CASE("faces of coarser levels show the mean, and their leaves are denser",
          "[raytracer][material]") {
    material::FacePoint at;
    at.face = core::Face::kNorth;
    at.u = 0.3;
    at.v = 0.8;
    float last = 0;
    for (int level = 1; level < 21; ++level) {
        at.level = level;
        INFO("level " << level);
        CHECK(std::abs(table().texel(Material::kRock, at).ratio.g - 1) < 1e-3f);
        const material::Texel leaves = table().texel(Material::kHighVegetation, at);
        CHECK(leaves.opacity >= last);
        if (level == 1)
            CHECK(leaves.opacity == Approx(1 - 0.32 * 0.32).margin(0.02));
        last = leaves.opacity;
    }
    CHECK(last == 1);
}

TEST_CASE("from afar a wall keeps the mean of its windows, their light and their gloss",
          "[raytracer][material]") {
    for (const double voxel_m : {0.5, 1.0, 2.0}) {
        INFO("voxel_m " << voxel_m);
        const WallMean near = wall_mean(voxel_m, 0, 0, 200'000);
        const WallMean far = wall_mean(voxel_m, 1000, 0, 10);
        const WallMean coarse = wall_mean(voxel_m, 0, 2, 10);
        CHECK(far.share == Approx(near.share).epsilon(0.04));
        CHECK(far.gloss == Approx(near.gloss).epsilon(0.05));
        CHECK(far.red == Approx(near.red).epsilon(0.05));
        CHECK(far.emission == Approx(near.emission).epsilon(0.08));
        CHECK(coarse.share == Approx(far.share));
        CHECK(coarse.emission == Approx(far.emission));
    }
}

TEST_CASE("water leans smoothly, the same at every size of voxel", "[raytracer][material]") {
    std::mt19937_64 random(3);
    const auto tilt = [](double x_m, double z_m, double voxel_m, int level, double footprint_m) {
        material::FacePoint at;
        const double x = x_m / std::ldexp(voxel_m, level);
        const double z = z_m / std::ldexp(voxel_m, level);
        at.voxel = {static_cast<std::int32_t>(std::floor(x)), 470,
                    static_cast<std::int32_t>(std::floor(z))};
        at.v = x - std::floor(x);
        at.u = z - std::floor(z);
        at.level = level;
        at.voxel_m = voxel_m;
        at.footprint = footprint_m / voxel_m;
        return table().texel(Material::kWater, at).tilt;
    };
    double most = 0;
    double sum = 0;
    for (int i = 0; i < 20'000; ++i) {
        const double x = 462'000 + static_cast<double>(random() % 100'000) / 100;
        const double z = -101'000 - static_cast<double>(random() % 100'000) / 100;
        const auto here = tilt(x, z, 1, 0, 0);
        const auto east = tilt(x + 0.01, z, 1, 0, 0);
        const auto coarse = tilt(x, z, 0.25, 3, 0);
        INFO(x << ' ' << z);
        REQUIRE(std::abs(here[0] - east[0]) < 0.003f);
        REQUIRE(std::abs(here[1] - east[1]) < 0.003f);
        REQUIRE(std::abs(here[0] - coarse[0]) < 1e-5f);
        most = std::max(
            {most, std::abs(static_cast<double>(here[0])), std::abs(static_cast<double>(here[1]))});
        sum += static_cast<double>(here[0]);
        CHECK(tilt(x, z, 1, 0, 100)[0] == 0);
    }
    CHECK(most > 0.01);
    CHECK(most < 0.12);
    CHECK(std::abs(sum / 20'000) < 0.003);
    material::FacePoint side;
    side.face = core::Face::kWest;
    CHECK(table().texel(Material::kWater, side).tilt == std::array<float, 2>{});
}
