#include "voxelserver/data/imagery/specialization.hpp"

#include "tests/voxelserver/data/imagery/image_files.hpp"

using namespace terravox;
using namespace terravox::test;
using namespace terravox::imagery;
using voxel::Material;
using voxel::Rgb8;

namespace {

constexpr Rgb8 kMeadow{112, 138, 66};
constexpr Rgb8 kAsphalt{116, 116, 120};
constexpr Rgb8 kTiles{178, 84, 56};
constexpr Rgb8 kSlate{118, 120, 126};
constexpr Rgb8 kLake{30, 84, 104};

/// One column of everything a column can be.
struct OneColumn {
    Group group = Group::kGround;
    Material own = Material::kGround;
    std::optional<Rgb8> image = {};
    std::optional<Rgb8> points = {};
    std::optional<std::array<std::uint8_t, 2>> nir_red = {};
    bool covered = false;
};

OneColumn roof(Rgb8 colour) {
    return {.group = Group::kBuilding, .own = Material::kRoof, .image = colour};
}

Grid specialized(const OneColumn& c) {
    static const ColourMap map = ColourMap::load("default");
    const std::vector<Rgb8> point{c.points.value_or(Rgb8{})};
    const std::vector<std::uint8_t> has_point{static_cast<std::uint8_t>(c.points ? 1 : 0)};
    const std::vector<std::uint8_t> covered{static_cast<std::uint8_t>(c.covered ? 1 : 0)};
    SurfaceColumns columns;
    columns.width = columns.height = 1;
    columns.group = {&c.group, 1};
    columns.material = {&c.own, 1};
    columns.covered = covered;
    if (c.points) {
        columns.point_colour = point;
        columns.has_point_colour = has_point;
    }
    Raster raster;
    if (c.image || c.nir_red) {
        raster.width = raster.height = 1;
        raster.colour = {c.image.value_or(Rgb8{})};
        raster.flags = {static_cast<std::uint8_t>((c.image ? Raster::kColour : 0) |
                                                  (c.nir_red ? Raster::kNir : 0))};
        if (c.nir_red) {
            raster.nir = {(*c.nir_red)[0]};
            raster.red = {(*c.nir_red)[1]};
        }
    }
    return specialize(columns, raster, map);
}

}  // namespace

TEST_CASE("a surface takes the material of its colour, as far as its group allows",
          "[voxelserver][imagery][specialization]") {
    struct Case {
        const char* name;
        OneColumn column;
        Material material;
        int flags;
    };
    const auto c = GENERATE(values<Case>({
        {"green ground", {.image = kMeadow}, Material::kGrass, 0},
        {"grey ground", {.group = Group::kDryGround, .image = kAsphalt}, Material::kRoad, 0},
        {"blue ground", {.image = kLake}, Material::kWater, 0},
        {"red roof", roof(kTiles), Material::kOrangeRoof, 0},
        {"grey roof", roof(kSlate), Material::kGreyRoof, 0},
        {"white roof", roof({240, 240, 238}), Material::kFlatRoof, 0},
        {"vegetation keeps its material",
         {Group::kVegetation, Material::kHighVegetation, kAsphalt},
         Material::kHighVegetation,
         Grid::kFixed},
        {"water of a class stays",
         {Group::kWater, Material::kWater, kMeadow},
         Material::kWater,
         Grid::kFixed},
        {"rails stay", {Group::kGround, Material::kRail, kMeadow}, Material::kRail, Grid::kFixed},
        {"nothing there", {Group::kNone, Material::kAir, kMeadow}, Material::kAir, Grid::kFixed},
        {"no colour", {}, Material::kGround, Grid::kSilent},
        {"the points' colour", {.points = kMeadow}, Material::kGrass, 0},
        {"the image before the points", {.image = kAsphalt, .points = kMeadow}, Material::kRoad, 0},
        {"covered by a crown",
         {.image = kMeadow, .points = kMeadow, .covered = true},
         Material::kGround,
         Grid::kSilent},
        {"grey with leaves", {.image = kAsphalt, .nir_red = {{200, 60}}}, Material::kGrass, 0},
        {"near infrared only, leaves", {.nir_red = {{200, 60}}}, Material::kGrass, 0},
        {"near infrared only, no leaves",
         {.nir_red = {{60, 60}}},
         Material::kGround,
         Grid::kSilent},
    }));
    DYNAMIC_SECTION(c.name) {
        const Grid grid = specialized(c.column);
        CHECK(voxel::material_name(grid.material[0]) == voxel::material_name(c.material));
        CHECK(int{grid.flags[0]} == c.flags);
    }
}

TEST_CASE("dry ground never becomes water", "[voxelserver][imagery][specialization]") {
    const ColourMap map = ColourMap::load("default");
    for (int r = 0; r < 256; r += 15)
        for (int g = 0; g < 256; g += 15)
            for (int b = 0; b < 256; b += 15)
                for (const float index : {kNoNdvi, -0.9F, 0.0F, 0.9F}) {
                    const Rgb8 colour{static_cast<std::uint8_t>(r), static_cast<std::uint8_t>(g),
                                      static_cast<std::uint8_t>(b)};
                    REQUIRE(map.nearest(colour, Group::kDryGround, index) != Material::kWater);
                }
}

TEST_CASE("the shipped colours mean what they were seen on",
          "[voxelserver][imagery][specialization]") {
    struct Case {
        const char* seen_on;
        Rgb8 colour;
        Group group;
        Material material;
    };
    const auto c = GENERATE(values<Case>({
        // IGN's orthophoto of Montpellier
        {"tiles", {203, 152, 132}, Group::kBuilding, Material::kOrangeRoof},
        {"tiles in the lee", {162, 116, 102}, Group::kBuilding, Material::kOrangeRoof},
        {"white terrace", {222, 218, 208}, Group::kBuilding, Material::kFlatRoof},
        {"lawn", {90, 104, 90}, Group::kGround, Material::kGrass},
        {"hedge in the shade", {48, 64, 52}, Group::kGround, Material::kGrass},
        {"shrubs", {65, 85, 66}, Group::kGround, Material::kGrass},
        {"yard of beaten earth", {146, 139, 120}, Group::kGround, Material::kGround},
        {"slabs", {189, 189, 179}, Group::kGround, Material::kConcrete},
        {"street", {133, 134, 140}, Group::kGround, Material::kRoad},
        // the synthetic survey
        {"meadow", {112, 138, 66}, Group::kGround, Material::kGrass},
        {"wheat", {200, 180, 114}, Group::kGround, Material::kGrass},
        {"maize", {78, 118, 48}, Group::kGround, Material::kGrass},
        {"ploughed field", {136, 106, 78}, Group::kGround, Material::kGround},
        {"asphalt", {116, 116, 120}, Group::kGround, Material::kRoad},
        {"gravel road", {196, 184, 158}, Group::kGround, Material::kGround},
        {"lake, deep", {30, 84, 104}, Group::kGround, Material::kWater},
        {"lake, shallow", {86, 150, 142}, Group::kGround, Material::kWater},
        {"river", {54, 96, 96}, Group::kGround, Material::kWater},
        {"red tiles", {178, 84, 56}, Group::kBuilding, Material::kOrangeRoof},
        {"slate", {118, 120, 126}, Group::kBuilding, Material::kGreyRoof},
        {"pale roof", {186, 182, 174}, Group::kBuilding, Material::kFlatRoof},
        // the benchmark square
        {"canal", {24, 60, 74}, Group::kGround, Material::kWater},
        {"canal, greener", {22, 66, 64}, Group::kGround, Material::kWater},
        {"roof", {188, 114, 113}, Group::kBuilding, Material::kOrangeRoof},
        {"forest floor", {61, 84, 45}, Group::kGround, Material::kGrass},
    }));
    static const ColourMap map = ColourMap::load("default");
    DYNAMIC_SECTION(c.seen_on) {
        CHECK(voxel::material_name(map.nearest(c.colour, c.group)) ==
              voxel::material_name(c.material));
    }
}

TEST_CASE("cells look wet where most of their valid columns are water",
          "[voxelserver][imagery][specialization]") {
    const auto w = Material::kWater;
    const auto g = Material::kGrass;
    const auto a = Material::kAir;
    const std::vector<Material> land{w, w, g, g, w,  //
                                     w, g, a, a, a,  //
                                     a, a, w, w, w};
    CHECK(looks_wet(land, {}, 5, 3, 2) == std::vector<std::uint8_t>{1, 0, 1, 0, 1, 1});
    CHECK(looks_wet(land, {}, 5, 3, 2, 0.8) == std::vector<std::uint8_t>{0, 0, 1, 0, 1, 1});
    const std::vector<std::uint8_t> valid{0, 0, 1, 1, 1, 0, 1, 1, 1, 1, 1, 1, 1, 1, 0};
    CHECK(looks_wet(land, valid, 5, 3, 2) == std::vector<std::uint8_t>{0, 0, 1, 0, 1, 0});
    CHECK(looks_wet(land, {}, 5, 3, 5, 0.5, 0.6) ==
          std::vector<std::uint8_t>{1});  // 10 of 15 are valid, 7 are wet
    CHECK(looks_wet(land, {}, 5, 3, 5, 0.5, 0.7) == std::vector<std::uint8_t>{0});
    CHECK_THROWS_WITH(looks_wet(land, {}, 5, 4, 2), contains("5 x 4 columns"));
    CHECK_THROWS_WITH(looks_wet(land, {}, 5, 3, 0), contains("allowed: 1 to 4096"));
}
