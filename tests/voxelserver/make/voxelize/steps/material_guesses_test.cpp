// Materials where no colour is known: from brightness and the shape of roofs.
#include "voxelserver/make/voxelize/steps/surface.hpp"

#include "tests/catch.hpp"
#include "tests/voxelserver/make/voxelize/steps/made_land.hpp"

using namespace terravox;
using namespace terravox::test;
using namespace terravox::voxelize;
using voxel::Material;

namespace {

using Returns = MadeLand::Returns;

/// Brightness is stored in place of a colour.
Return echo(double height, std::uint8_t code, int brightness) {
    return {height, code, {static_cast<std::uint8_t>(brightness), 0, 0}};
}

/// The surface of the middle patch after all steps that choose its materials.
SurfaceAppearance find_surface(MadeLand& land, const Settings& settings = {},
                               grid::PatchKey patch = {0, 0}) {
    util::StageTimes times;
    SurfaceStep step(nullptr, nullptr, asprs(), settings, true, 1, std::size_t{64} << 20, times);
    const Window window = land.window(patch);
    auto out = step.surface(window, step.appearances(window));
    if (settings.steps.material_guesses)
        guess_roofs(window, asprs(), Buildings(window, 1), settings.material_guesses, out);
    return out;
}

/// A house of 20 x 12 columns whose roof rises by this much in a column, from both eaves to a
/// ridge.
MadeLand house(double slope, int brightness) {
    return MadeLand([=](int x, int z, Returns& out) {
        const bool inside = x >= 20 && x < 40 && z >= 20 && z < 32;
        if (!inside) {
            out.push_back({10.5, kGroundClass});
            return;
        }
        const double from_ridge = std::abs(z - 25.5);
        out.push_back(echo(20 - slope * from_ridge, kBuilding, brightness));
    });
}

}  // namespace

TEST_CASE("ground is asphalt, bare or grass by its brightness",
          "[voxelserver][voxelize][guesses]") {
    struct Case {
        int brightness;
        Material wanted;
    };
    const auto c = GENERATE(values<Case>({{20, Material::kRoad},
                                          {37, Material::kRoad},
                                          {39, Material::kGround},
                                          {71, Material::kGround},
                                          {73, Material::kGrass},
                                          {255, Material::kGrass},
                                          {0, Material::kAir}}));
    MadeLand land(
        [&](int, int, Returns& out) { out.push_back(echo(10.5, kGroundClass, c.brightness)); });
    const auto surface = find_surface(land);
    INFO(c.brightness);
    CHECK(surface.material.at(30, 30) == c.wanted);
    CHECK(surface.guessed.at(30, 30) == 1);
}

TEST_CASE("a measured colour is stronger than a guess, and is none",
          "[voxelserver][voxelize][guesses]") {
    MadeLand land(
        [](int, int, Returns& out) { out.push_back({10.5, kGroundClass, {0x70, 0x89, 0x4a}}); },
        true);
    const auto surface = find_surface(land);
    CHECK(surface.material.at(30, 30) == Material::kGrass);
    CHECK(surface.guessed.at(30, 30) == 0);
}

TEST_CASE("roofs are flat, tiled or of slate by shape and brightness",
          "[voxelserver][voxelize][guesses]") {
    struct Case {
        const char* name;
        double slope;
        int brightness;
        Material wanted;
    };
    const auto c = GENERATE(values<Case>({
        {"flat and dark", 0, 30, Material::kFlatRoof},
        {"flat, brightness unknown", 0, 0, Material::kFlatRoof},
        {"slightly inclined", 0.05, 90, Material::kFlatRoof},
        {"steep and bright", 0.7, 90, Material::kOrangeRoof},
        {"steep and dark", 0.7, 35, Material::kGreyRoof},
        {"steep, brightness unknown", 0.7, 0, Material::kAir},
    }));
    MadeLand land = house(c.slope, c.brightness);
    const auto surface = find_surface(land);
    for (int z = 20; z < 32; ++z)
        for (int x = 20; x < 40; ++x) {
            INFO(c.name << ": " << x << ", " << z);
            REQUIRE(surface.material.at(x, z) == c.wanted);
        }
}
