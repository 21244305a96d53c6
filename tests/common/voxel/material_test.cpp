#include "common/voxel/material.hpp"

#include <unistd.h>

#include <vector>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/common/content.hpp"
#include "tests/common/temporary_folder.hpp"

using namespace terravox;
using namespace terravox::voxel;
using terravox::test::contains;
using terravox::test::TemporaryFolder;

namespace {

const std::filesystem::path kShipped =
    std::filesystem::path(TERRAVOX_SOURCE_DIR) / "config/materials.toml";

// The shipped file with one piece of text replaced.
std::filesystem::path altered(const TemporaryFolder& folder, const std::string& from,
                              const std::string& to) {
    terravox::test::write_content(
        folder.path() / "materials.toml",
        terravox::test::replaced(terravox::test::read_content(kShipped), from, to));
    return folder.path() / "materials.toml";
}

}  // namespace

TEST_CASE("every material has a name that leads back to it", "[common][voxel][material]") {
    for (int i = 0; i < kMaterialCount; ++i) {
        const auto material = static_cast<Material>(i);
        INFO(i << " " << material_name(material));
        CHECK(material_from_name(material_name(material)) == material);
    }
    CHECK(material_name(Material::kMediumVegetation) == "medium_vegetation");
    CHECK(material_name(Material::kUnknown) == "unknown");
    CHECK(material_name(static_cast<Material>(200)) == "unknown");
    CHECK_FALSE(material_from_name("cheese"));
    CHECK_FALSE(material_from_name(""));
}

TEST_CASE("materials have names, blocks and old numbers of their own form",
          "[common][voxel][material]") {
    for (const MaterialTraits& traits : kMaterialTraits) {
        INFO(traits.name);
        CHECK(traits.name.find_first_not_of("abcdefghijklmnopqrstuvwxyz_") == traits.name.npos);
        CHECK(!traits.block.empty());
        CHECK(traits.old_block.data < 16);
        CHECK((traits.old_block.id == 0) == (traits.material == Material::kAir));
        CHECK((traits.optics == Optics::kAir) == (traits.material == Material::kAir));
    }
}

TEST_CASE("light passes air, water, leaves, wires, glass and ice, nothing else",
          "[common][voxel][material]") {
    int passing = 0;
    for (int i = 0; i < kMaterialCount; ++i)
        passing += see_through(static_cast<Material>(i));
    CHECK(passing == 8);
    for (const Material m :
         {Material::kAir, Material::kWater, Material::kLowVegetation, Material::kMediumVegetation,
          Material::kHighVegetation, Material::kWire, Material::kGlass, Material::kIce})
        CHECK(see_through(m));
}

TEST_CASE("the shipped materials load, each with its colour", "[common][voxel][material]") {
    const Palette palette = load_palette(kShipped);
    CHECK(palette.of(Material::kWater).colour == Rgb8{0x2f, 0x5d, 0x72});
    CHECK(palette.of(Material::kHighVegetation).variation == 0.20f);
    for (int i = 1; i < kMaterialCount; ++i) {
        const auto material = static_cast<Material>(i);
        INFO(material_name(material));
        CHECK(palette.of(material).colour != Rgb8{});
    }
    // A number from a newer file must not lead outside the table.
    CHECK_NOTHROW((void)palette.of(static_cast<Material>(255)));
}

TEST_CASE("a wrong materials file is refused by file, field and value",
          "[common][voxel][material]") {
    struct Case {
        const char* name;
        std::string from;
        std::string to;
        std::vector<std::string> said;
    };
    const auto c = GENERATE(values<Case>({
        {"a material is missing", "snow =", "snowy =", {"[snow]", "colour is missing", "#rrggbb"}},
        {"a colour is missing",
         "grass = { colour",
         "grass = { color",
         {"[grass]", "colour is missing"}},
        {"a colour is a number", "\"#7f9a4c\"", "8362572", {"[grass]", "colour"}},
        {"a colour is too short", "#7f9a4c", "#7f9", {"[grass]", "'#7f9'", "#rrggbb"}},
        {"a colour has no hash", "#7f9a4c", "77f9a4c", {"[grass]", "'77f9a4c'"}},
        {"a colour has a foreign digit", "#7f9a4c", "#7f9a4g", {"[grass]", "'#7f9a4g'"}},
        {"a variation is above one", "0.12 }", "1.5 }", {"variation = 1.5", "0 to 1"}},
        {"a variation is negative", "0.12 }", "-0.1 }", {"variation = -0.1", "0 to 1"}},
        {"a variation is no number", "0.12 }", "nan }", {"variation", "0 to 1"}},
        {"a variation is text", "0.12 }", "\"much\" }", {"variation", "0 to 1"}},
        {"an unknown material",
         "trunk =",
         "magma = { colour = \"#ff0000\" }\ntrunk =",
         {"[magma]", "is no material"}},
        {"an unknown field",
         "0.12 }",
         "0.12, shine = 1 }",
         {"shine is no field", "colour, variation"}},
        {"it is not TOML", "grass =", "grass = = ", {"line"}},
    }));
    DYNAMIC_SECTION(c.name) {
        const TemporaryFolder folder;
        const auto file = altered(folder, c.from, c.to);
        CHECK_THROWS_AS(load_palette(file), util::Error);
        CHECK_THROWS_WITH(load_palette(file), contains(file.string()));
        for (const auto& part : c.said)
            CHECK_THROWS_WITH(load_palette(file), contains(part));
    }
    CHECK_THROWS_WITH(load_palette("/nowhere/materials.toml"), contains("/nowhere/materials.toml"));
}
