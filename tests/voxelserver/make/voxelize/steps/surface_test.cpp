// What surfaces look like from above: materials from colours, and colours from images.
// Materials where no colour is known: from brightness and the shape of roofs.
// Typical colours by building and tree.
#include <algorithm>
#include <fstream>
#include <functional>
#include <set>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/voxelserver/image_file.hpp"
#include "tests/voxelserver/make/voxelize/steps/made_land.hpp"
#include "voxelserver/make/voxelize/steps/colour_variation.hpp"
#include "voxelserver/make/voxelize/steps/surface.hpp"

using namespace terravox;
using namespace terravox::test;
using namespace terravox::voxelize;
using voxel::Material;
using voxel::Rgb8;
using voxelize::number_of_place;
using voxelize::Tints;

namespace {

using Returns = MadeLand::Returns;
// Of the default palette.
constexpr Rgb8 kMeadow{0x70, 0x89, 0x4a};
constexpr Rgb8 kAsphalt{0x74, 0x74, 0x78};
constexpr Rgb8 kTiles{0xb2, 0x54, 0x38};
constexpr Rgb8 kSlate{0x76, 0x7a, 0x7e};
constexpr Rgb8 kDeepLake{0x1e, 0x54, 0x68};

/// The step with its own times, without images unless given.
class Step {
public:
    explicit Step(Settings settings = {}, const imagery::Orthophotos* images = nullptr,
                  bool dry = true)
        : m_settings(std::move(settings)),
          m_step(images, nullptr, asprs(), m_settings, dry, 1, std::size_t{64} << 20, m_times) {}
    [[nodiscard]] SurfaceStep& operator*() { return m_step; }
    [[nodiscard]] SurfaceStep* operator->() { return &m_step; }

private:
    Settings m_settings;
    util::StageTimes m_times;
    SurfaceStep m_step;
};

/// One image of 1 m pixels: columns [x0, x0 + width) x [z0, z0 + height) of voxels of 1 m.
void write_image(const std::filesystem::path& file, int x0, int z0, int width, int height,
                 const std::function<Rgb8(int x, int z)>& colour_at) {
    ImageFile image;
    image.width = width;
    image.height = height;
    image.geo = {static_cast<double>(x0), 1, 0, static_cast<double>(-z0), 0, -1};
    image.value = [&](int x, int y, int band) {
        const Rgb8 c = colour_at(x0 + x, z0 + y);
        return band == 0 ? c.r : band == 1 ? c.g : c.b;
    };
    test::write_image(file, image);
}

SurfaceAppearance find_appearance(SurfaceStep& step, const Window& window) {
    return step.surface(window, step.appearances(window));
}

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

Tints read_tints(const TemporaryFolder& folder, const std::string& text) {
    const auto file = folder.path() / "mine.toml";
    std::ofstream(file) << text;
    return Tints::load(file.string());
}

}  // namespace

TEST_CASE("materials of ground and roofs come from their points' colours",
          "[voxelserver][voxelize][surface]") {
    struct Case {
        const char* name;
        std::uint8_t code;
        Rgb8 colour;
        bool coloured;
        Material wanted;
    };
    const auto c = GENERATE(values<Case>({
        {"a meadow", kGroundClass, kMeadow, true, Material::kGrass},
        {"a road", kGroundClass, kAsphalt, true, Material::kRoad},
        {"tiles", kBuilding, kTiles, true, Material::kOrangeRoof},
        {"slate", kBuilding, kSlate, true, Material::kGreyRoof},
        {"ground of tiles' colour is no roof", kGroundClass, kTiles, true, Material::kGround},
        {"a roof of a meadow's colour is no grass", kBuilding, kMeadow, true, Material::kGreyRoof},
        {"a class that says what it is", 11, kMeadow, true, Material::kRoad},
        {"no colours", kGroundClass, {}, false, Material::kAir},
    }));
    DYNAMIC_SECTION(c.name) {
        MadeLand land([&](int, int, Returns& out) { out.push_back({10, c.code, c.colour}); },
                      c.coloured);
        Step step;
        const auto appearance = find_appearance(*step, land.window({0, 0}));
        Margined<Material>::each([&](int x, int z) {
            INFO("column " << x << ", " << z << ": "
                           << voxel::material_name(appearance.material.at(x, z)));
            REQUIRE(appearance.material.at(x, z) == c.wanted);
        });
        CHECK(appearance.colour(5, 5) == nullptr);
    }
}

TEST_CASE("with specialization off no material changes", "[voxelserver][voxelize][surface]") {
    Settings settings;
    settings.steps.specialization = false;
    MadeLand land([](int, int, Returns& out) { out.push_back({10, kGroundClass, kMeadow}); }, true);
    Step step(settings);
    const auto appearance = find_appearance(*step, land.window({0, 0}));
    CHECK(std::all_of(appearance.material.values().begin(), appearance.material.values().end(),
                      [](Material m) { return m == Material::kAir; }));
    CHECK_FALSE(step->finds_water());
}

TEST_CASE("a single speck is filtered away, unless the filters are off",
          "[voxelserver][voxelize][surface]") {
    const bool filters = GENERATE(true, false);
    Settings settings;
    settings.steps.neighbourhood_filters = filters;
    MadeLand land(
        [](int x, int z, Returns& out) {
            out.push_back({10, kGroundClass, x == 20 && z == 20 ? kAsphalt : kMeadow});
        },
        true);
    Step step(settings);
    const auto appearance = find_appearance(*step, land.window({0, 0}));
    CHECK(appearance.material.at(20, 20) == (filters ? Material::kGrass : Material::kRoad));
    CHECK(appearance.material.at(25, 20) == Material::kGrass);
}

TEST_CASE(
    "what is hidden from above takes its neighbours' material, not the colour of what hides it",
    "[voxelserver][voxelize][surface]") {
    struct Case {
        const char* name;
        Return above;
        bool hidden;
    };
    const auto c = GENERATE(values<Case>({{"a crown", {22, kTree, kMeadow}, true},
                                          {"high crops", {11, kLow, kMeadow}, false},
                                          {"a deck", {22, kBridge, kMeadow}, true}}));
    DYNAMIC_SECTION(c.name) {
        // A meadow's colour in the image over a road.
        const TemporaryFolder folder;
        const auto covered = [](int x, int z) { return x >= 20 && x < 22 && z >= 20 && z < 22; };
        write_image(folder.path() / "image.tif", -64, -64, 192, 192,
                    [&](int x, int z) { return covered(x, z) ? kMeadow : kAsphalt; });
        const imagery::Orthophotos images({folder.path() / "image.tif"},
                                          grid::Frame(geo::Crs::from_text(kCrs), 1, 0, 0));
        Settings settings;
        settings.steps.neighbourhood_filters =
            c.hidden;  // hidden columns take the filters' result; the others show what they are
        MadeLand land([&](int x, int z, Returns& out) {
            out.push_back({10, kGroundClass});
            if (covered(x, z))
                out.push_back(c.above);
        });
        Step step(settings, &images);
        const auto appearance = find_appearance(*step, land.window({0, 0}));
        for (int z = 20; z < 22; ++z)
            for (int x = 20; x < 22; ++x)
                CHECK(appearance.material.at(x, z) ==
                      (c.hidden ? Material::kRoad : Material::kGrass));
        REQUIRE(appearance.colour(20, 20) != nullptr);
        CHECK(*appearance.colour(20, 20) == kMeadow);
    }
}

TEST_CASE("an image that shows a part colours that part; elsewhere points say what they know",
          "[voxelserver][voxelize][surface]") {
    const TemporaryFolder folder;
    write_image(folder.path() / "image.tif", -64, -64, 64 + 30, 192,
                [](int, int) { return kMeadow; });
    const imagery::Orthophotos images({folder.path() / "image.tif"},
                                      grid::Frame(geo::Crs::from_text(kCrs), 1, 0, 0));
    const bool coloured = GENERATE(true, false);
    MadeLand land(
        [&](int, int, Returns& out) {
            out.push_back({10, kGroundClass, coloured ? kAsphalt : Rgb8{}});
        },
        coloured);
    Step step({}, &images);
    const auto appearance = find_appearance(*step, land.window({0, 0}));
    for (int z = 0; z < 64; ++z)
        for (int x = 0; x < 64; ++x) {
            INFO("column " << x << ", " << z);
            const Rgb8* colour = appearance.colour(x, z);
            REQUIRE((colour != nullptr) == (x < 30));
            if (colour != nullptr)
                REQUIRE(*colour == kMeadow);
            const Material m = appearance.material.at(x, z);
            if (x < 26)
                REQUIRE(m == Material::kGrass);  // the filters mix what lies along the image's edge
            if (x >= 40)
                REQUIRE(m == (coloured ? Material::kRoad : Material::kGround));
        }
}

TEST_CASE(
    "cells look wet where an image shows water on seen ground of a survey without a class for it",
    "[voxelserver][voxelize][surface]") {
    const TemporaryFolder folder;
    write_image(folder.path() / "image.tif", 0, 0, 64, 64,
                [](int x, int) { return x < 32 ? kDeepLake : kMeadow; });
    const imagery::Orthophotos images({folder.path() / "image.tif"},
                                      grid::Frame(geo::Crs::from_text(kCrs), 1, 0, 0));
    MadeLand land([](int, int z, Returns& out) {
        if (z < 48)
            out.push_back({10, kGroundClass});
    });
    Step wet({}, &images, false);
    Step dry({}, &images, true);
    CHECK(wet->finds_water());
    CHECK_FALSE(dry->finds_water());
    const auto columns = land.columns({0, 0});
    auto cells = columns->cells;
    wet->mark_wet({0, 0}, *columns, land.cell_voxels(), cells);
    for (int z = 0; z < cells.side; ++z)
        for (int x = 0; x < cells.side; ++x)
            REQUIRE(cells.at(x, z).looks_wet == (x < 16 && z < 24));
}

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

TEST_CASE("the tints that ship vary roofs, walls and crowns, and nothing that is measured",
          "[voxelserver][voxelize][tints]") {
    const Tints tints = Tints::load("default");
    for (const Material m : {Material::kRoof, Material::kOrangeRoof, Material::kGreyRoof,
                             Material::kFlatRoof, Material::kWall, Material::kHighVegetation}) {
        std::set<std::array<int, 3>> seen;
        for (int x = 0; x < 100; ++x) {
            const auto colour = tints.of(m, number_of_place(x, 5, 1));
            REQUIRE(colour);
            CHECK(colour == tints.of(m, number_of_place(x, 5, 1)));
            seen.insert({colour->r, colour->g, colour->b});
        }
        INFO(voxel::material_name(m));
        CHECK(seen.size() > 20);
    }
    for (const Material m : {Material::kGround, Material::kWater, Material::kRoad})
        CHECK_FALSE(tints.of(m, 1));
}

TEST_CASE("without a brightness of its own a tint is exactly one of the list",
          "[voxelserver][voxelize][tints]") {
    const TemporaryFolder folder;
    const Tints tints = read_tints(folder, "[colours]\nwall = ['#102030', '#AABBCC']\n");
    std::set<std::array<int, 3>> seen;
    for (int i = 0; i < 50; ++i) {
        const auto colour = tints.of(Material::kWall, number_of_place(i, -i, 2));
        REQUIRE(colour);
        seen.insert({colour->r, colour->g, colour->b});
    }
    CHECK(seen == std::set<std::array<int, 3>>{{0x10, 0x20, 0x30}, {0xaa, 0xbb, 0xcc}});
    CHECK_FALSE(tints.of(Material::kRoof, 7));
}

TEST_CASE("bad tints are refused, naming what is wrong", "[voxelserver][voxelize][tints][bad]") {
    struct Case {
        const char* text;
        const char* part;
    };
    const auto c = GENERATE(values<Case>({
        {"[colours]\nwall = []\n", "colours.wall"},
        {"[colours]\nwall = ['red']\n", "\"#rrggbb\""},
        {"[colours]\nwall = [7]\n", "\"#rrggbb\""},
        {"[colours]\nwool = ['#102030']\n", "colours.wool is no material"},
        {"colours = 3\n", "[colours]"},
        {"brightness = 0.7\n[colours]\n", "allowed: 0 to 0.5"},
        {"brightness = true\n[colours]\n", "allowed: 0 to 0.5"},
        {"colour = 3\n[colours]\n", "colour is no field"},
        {"", "[colours]"},
    }));
    const TemporaryFolder folder;
    INFO(c.text);
    CHECK_THROWS_AS(read_tints(folder, c.text), util::UsageError);
    CHECK_THROWS_WITH(read_tints(folder, c.text), contains("mine.toml") && contains(c.part));
}

TEST_CASE("tints that do not exist are refused with those that do",
          "[voxelserver][voxelize][tints][bad]") {
    CHECK_THROWS_WITH(Tints::load("pastel"), contains("'pastel'") && contains("default"));
    CHECK_THROWS_WITH(Tints::load("../x"), contains("default"));
    CHECK_THROWS_WITH(Tints::load("no/such.toml"), contains("no such file"));
}
