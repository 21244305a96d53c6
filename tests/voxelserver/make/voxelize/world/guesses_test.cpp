// Materials of surveys without colours: whole worlds, cut in several ways.
#include <algorithm>
#include <random>

#include "tests/catch.hpp"
#include "tests/voxelserver/make/voxelize/world/cloud.hpp"

using namespace terravox;
using namespace terravox::test;
using voxel::Material;

namespace {

/// 300 x 200 m: two streets that cross in a meadow, fields of bare soil, houses with tiles and with
/// slate. Three flight lines that overlap.
const Cloud& village() {
    static const Cloud made = [] {
        Cloud out;
        std::mt19937 random(5);
        const auto unit = [&] { return static_cast<double>(random() % 100'000) / 100'000; };
        for (int i = 0; i < 360'000; ++i) {
            const auto line = static_cast<std::uint16_t>(1 + i % 3);
            const double e = std::clamp(100.0 * (line - 1) - 30 + unit() * 160, 0.02, 299.98);
            const double n = 0.02 + unit() * 199.96;
            const double noise = 0.85 + 0.3 * unit();
            const std::array<double, 3> gains{1, 0.6, 1.5};  // of the flight lines
            const auto add = [&](double height, std::uint8_t source_class, double light) {
                out.add({e,
                         n,
                         height,
                         source_class,
                         {},
                         static_cast<std::uint16_t>(light * noise * gains[line - 1U]),
                         line});
            };
            const bool road = std::abs(e - 150) < 5 || std::abs(n - 100) < 5;
            const double in_e = std::fmod(e, 60);
            const double in_n = std::fmod(n, 50);
            if (!road && in_e > 20 && in_e < 38 && in_n > 15 && in_n < 27) {
                const bool tiles = static_cast<int>(e / 60 + n / 50) % 2 == 0;
                const double height = 30 - 0.7 * std::abs(in_n - 21);
                add(height, 6, tiles ? 26'000 : 9000);
                continue;
            }
            const bool bare = e > 240 && n > 120;
            add(20.4, 2, road ? 8000 : bare ? 19'000 : 34'000);
        }
        return out;
    }();
    return made;
}

Material material_at(OpenWorld& world, double east, double north) {
    const auto top = world.top_voxel(voxel_x(east), voxel_z(north));
    return top ? top->material : Material::kAir;
}

/// The share of columns whose highest voxels differ in material.
double difference(OpenWorld& a, OpenWorld& b) {
    int all = 0;
    int different = 0;
    for (double n = 1.5; n < 199; ++n)
        for (double e = 1.5; e < 299; ++e) {
            ++all;
            different += material_at(a, e, n) != material_at(b, e, n) ? 1 : 0;
        }
    return static_cast<double>(different) / all;
}

}  // namespace

TEST_CASE("a village without colours has streets, meadows, soil, tiles and slate, all guessed",
          "[voxelserver][voxelize][guesses]") {
    const TemporaryFolder folder;
    village().write(folder.path() / "all.laz");
    OpenWorld world(folder.path() / "all.laz");
    CHECK(material_at(world, 150.5, 60.5) == Material::kRoad);
    CHECK(material_at(world, 60.5, 100.5) == Material::kRoad);
    CHECK(material_at(world, 100.5, 80.5) == Material::kGrass);
    CHECK(material_at(world, 290.5, 190.5) == Material::kGround);
    CHECK(material_at(world, 29.5, 20.5) == Material::kOrangeRoof);
    CHECK(material_at(world, 89.5, 20.5) == Material::kGreyRoof);
    const auto road = world.top_voxel(voxel_x(150.5), voxel_z(60.5));
    REQUIRE(road);
    CHECK(road->is_guessed());
    CHECK_FALSE(road->has_colour());
    const auto roof = world.top_voxel(voxel_x(29.5), voxel_z(20.5));
    REQUIRE(roof);
    CHECK(roof->is_guessed());
    CHECK(roof->is_tinted());
}

TEST_CASE("one file or two that touch have the same materials",
          "[voxelserver][voxelize][guesses][seamless]") {
    const TemporaryFolder one;
    const TemporaryFolder two;
    using Point = Cloud::Point;
    village().write(one.path() / "all.laz");
    village().write(two.path() / "west.laz", kCrs, 6,
                    [](const Point& p) { return p.east < 131.3; });
    village().write(two.path() / "east.laz", kCrs, 6,
                    [](const Point& p) { return p.east >= 131.3; });
    OpenWorld whole(one.path());
    OpenWorld cut(two.path());
    CHECK(difference(whole, cut) < 0.002);
}
