#include <fstream>

#include "common/util/error.hpp"
#include "raytracer/core/material/material_table.hpp"
#include "raytracer/core/material/texture_list.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"

using namespace terravox;
using namespace terravox::material;
using terravox::test::contains;
using terravox::test::TemporaryFolder;
using voxel::Material;

namespace {

const std::filesystem::path kShipped =
    std::filesystem::path(TERRAVOX_SOURCE_DIR) / "config/materials.toml";

std::filesystem::path written(const TemporaryFolder& folder, const std::string& text) {
    std::ofstream(folder.path() / "materials.toml") << text;
    return folder.path() / "materials.toml";
}
const material::MaterialAppearance& appearance(const MaterialFile& file, Material material) {
    return file.appearances[static_cast<std::size_t>(material)];
}

}  // namespace

TEST_CASE(
    "the shipped materials are whole, and each has a texture but unknown and those that are clear, "
    "lit or of one colour",
    "[raytracer][material]") {
    const MaterialFile file = read_materials(kShipped);
    CHECK(file.missing.empty());
    for (int i = 1; i < voxel::kMaterialCount; ++i) {
        const auto material = static_cast<Material>(i);
        INFO(voxel::material_name(material));
        const bool bare = material == Material::kUnknown || material == Material::kGlass ||
                          material == Material::kIce || material == Material::kLamp ||
                          material == Material::kPlain;
        CHECK((appearance(file, material).texture > 0) != bare);
    }
    const material::MaterialAppearance& water = appearance(file, Material::kWater);
    CHECK(water.kind == material::Kind::kWater);
    CHECK(water.index == 1.333f);
    CHECK(water.absorption_per_m.r > water.absorption_per_m.g);
    CHECK(water.glow.b > water.glow.r);
    for (const Material m :
         {Material::kLowVegetation, Material::kMediumVegetation, Material::kHighVegetation})
        CHECK(appearance(file, m).kind == material::Kind::kLeaves);
    CHECK(appearance(file, Material::kWall).emission.r >
          appearance(file, Material::kWall).emission.b);
}

TEST_CASE("every field of a material is read, and has a default", "[raytracer][material]") {
    const TemporaryFolder folder;
    const MaterialFile file = read_materials(written(folder, R"(
rock = { colour = "#ffffff" }
[snow]
colour = "#000000"
variation = 0.25
texture = "snow"
kind = "glass"
roughness = 0.5
index = 1.31
absorption = [1, 2.5, 1000]
glow = [0, 0.5, 1]
emission = [3, 0, 0.25]
reflects = true
)"));
    const material::MaterialAppearance& plain = appearance(file, Material::kRock);
    CHECK(plain.colour.r == 1);
    CHECK(plain.variation == 0);
    CHECK(plain.texture == 0);
    CHECK(plain.kind == material::Kind::kSolid);
    CHECK(plain.roughness == 1);
    CHECK(plain.index == 1.5f);
    CHECK(plain.emission.r == 0);
    CHECK_FALSE(plain.reflects);
    const material::MaterialAppearance& snow = appearance(file, Material::kSnow);
    CHECK(snow.colour.r == 0);
    CHECK(snow.variation == 0.25f);
    CHECK(snow.texture == texture_number("snow"));
    CHECK(snow.kind == material::Kind::kGlass);
    CHECK(snow.roughness == 0.5f);
    CHECK(snow.index == 1.31f);
    CHECK(snow.absorption_per_m.g == 2.5f);
    CHECK(snow.glow.b == 1);
    CHECK(snow.emission.r == 3);
    CHECK(snow.emission.b == 0.25f);
    CHECK(snow.reflects);
}

TEST_CASE("a material that the file lacks has the colour of unknown", "[raytracer][material]") {
    const TemporaryFolder folder;
    SECTION("which the file has") {
        const MaterialFile file = read_materials(written(
            folder, "rock = { colour = \"#ffffff\" }\nunknown = { colour = \"#0000ff\" }\n"));
        CHECK(static_cast<int>(file.missing.size()) == voxel::kMaterialCount - 3);
        CHECK(appearance(file, Material::kSnow).colour.b == 1);
        CHECK(appearance(file, Material::kRock).colour.r == 1);
    }
    SECTION("which it lacks, too: magenta") {
        const MaterialFile file = read_materials(written(folder, ""));
        CHECK(static_cast<int>(file.missing.size()) == voxel::kMaterialCount - 1);
        const voxel::Colour c = appearance(file, Material::kWater).colour;
        CHECK((c.r > 2 * c.g && c.b > 2 * c.g));
        CHECK_NOTHROW(material::MaterialTable(written(folder, "")));
    }
}

TEST_CASE("a table `default` stands for the materials that a file does not name",
          "[raytracer][material]") {
    const TemporaryFolder folder;
    const MaterialFile file =
        read_materials(written(folder,
                               "default = { colour = \"#00ff00\", roughness = 0.5 }\n"
                               "rock = { colour = \"#ffffff\" }\n"));
    CHECK(file.missing.empty());
    CHECK(appearance(file, Material::kSnow).colour.g == 1);
    CHECK(appearance(file, Material::kSnow).roughness == 0.5f);
    CHECK(appearance(file, Material::kUnknown).colour.r == 0);
    CHECK(appearance(file, Material::kRock).colour.r == 1);
    CHECK(appearance(file, Material::kRock).roughness == 1);
    CHECK_THROWS_WITH(read_materials(written(folder, "default = { colour = \"green\" }\n")),
                      contains("[default] colour = 'green'"));
}

TEST_CASE("a wrong field of a material is refused by file, material, field, value and range",
          "[raytracer][material]") {
    struct Case {
        const char* name;
        std::string text;
        std::vector<std::string> said;
    };
    const auto c = GENERATE(values<Case>({
        {"no colour", "rock = { variation = 0.1 }", {"[rock]", "colour = missing", "#rrggbb"}},
        {"a colour too short", "rock = { colour = \"#fff\" }", {"[rock]", "'#fff'", "#rrggbb"}},
        {"a variation too large",
         "rock = { colour = \"#ffffff\", variation = 1.5 }",
         {"variation = 1.5", "0 to 1"}},
        {"a roughness of nan",
         "rock = { colour = \"#ffffff\", roughness = nan }",
         {"roughness", "0 to 1"}},
        {"an index below 1",
         "rock = { colour = \"#ffffff\", index = 0.9 }",
         {"index = 0.9", "1 to 4"}},
        {"an infinite emission",
         "rock = { colour = \"#ffffff\", emission = [inf, 0, 0] }",
         {"emission = inf", "0 to 1000"}},
        {"an absorption of two numbers",
         "rock = { colour = \"#ffffff\", absorption = [1, 2] }",
         {"absorption = 2 numbers", "[r, g, b]"}},
        {"a negative absorption",
         "rock = { colour = \"#ffffff\", absorption = [1, 2, -1] }",
         {"absorption = -1", "0 to 1000"}},
        {"a kind that nobody knows",
         "rock = { colour = \"#ffffff\", kind = \"gas\" }",
         {"kind = 'gas'", "solid, leaves, water, glass"}},
        {"a texture that nobody knows",
         "rock = { colour = \"#ffffff\", texture = \"marble\" }",
         {"texture = 'marble'", "none, grass"}},
        {"reflects is a number",
         "rock = { colour = \"#ffffff\", reflects = 1 }",
         {"reflects = 1", "true or false"}},
        {"a field that nobody knows",
         "rock = { colour = \"#ffffff\", shine = 1 }",
         {"[rock] shine is no field", "colour, variation, texture"}},
        {"a material that nobody knows",
         "magma = { colour = \"#ffffff\" }",
         {"[magma] is no material"}},
        {"air", "air = { colour = \"#ffffff\" }", {"[air] is no material"}},
        {"a material that is a number", "rock = 5", {"[rock] is no table"}},
        {"it is not TOML", "rock = = 5", {"line"}},
    }));
    DYNAMIC_SECTION(c.name) {
        const TemporaryFolder folder;
        const auto file = written(folder, c.text + "\n");
        CHECK_THROWS_AS(read_materials(file), util::Error);
        CHECK_THROWS_WITH(read_materials(file), contains(file.string()));
        for (const auto& part : c.said)
            CHECK_THROWS_WITH(read_materials(file), contains(part));
    }
}

TEST_CASE("the palette of colours reads the same file", "[raytracer][material]") {
    const voxel::Palette palette = voxel::load_palette(kShipped);
    const MaterialFile file = read_materials(kShipped);
    for (int i = 1; i < voxel::kMaterialCount; ++i) {
        const auto material = static_cast<Material>(i);
        INFO(voxel::material_name(material));
        CHECK(voxel::to_linear(palette.of(material).colour).g ==
              appearance(file, material).colour.g);
        CHECK(palette.of(material).variation == appearance(file, material).variation);
    }
}
