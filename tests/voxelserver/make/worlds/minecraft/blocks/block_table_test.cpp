#include "voxelserver/make/worlds/minecraft/blocks/block_table.hpp"

#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"

namespace fs = std::filesystem;
using namespace terravox;
using namespace terravox::minecraft;
using terravox::voxel::Material;

namespace {

const fs::path kShipped = fs::path(TERRAVOX_SOURCE_DIR) / "config/blocks";

const BlockTable& shipped() {
    static const BlockTable table = BlockTable::load(kShipped);
    return table;
}

BlockAppearance appearance(const std::string& state) {
    const BlockState parsed =
        block_state_from(state, [](const std::string& what) { throw util::Error(what); });
    std::vector<Property> properties;
    for (const Condition& c : parsed.conditions)
        properties.push_back({c.property, c.values.front()});
    return shipped().of(parsed.name, properties);
}

/// A folder with a table of its own.
struct Folder {
    test::TemporaryFolder folder;
    const fs::path& path = folder.path();
    explicit Folder(const std::string& blocks, const std::string& old = "") {
        std::ofstream(path / "blocks.toml") << blocks;
        std::ofstream(path / "old-blocks.toml") << old;
    }
};

}  // namespace

TEST_CASE(
    "every block that a version since 1.13 names is known, and none by a star but what grows in "
    "pots",
    "[minecraft][blocks]") {
    std::ifstream table(kShipped / "blocks.toml");
    std::string line;
    std::string text;
    while (std::getline(table, line))
        if (line.substr(0, line.find(" = ")).find('*') == std::string::npos ||
            line.rfind("\"potted_", 0) == 0)
            text += line + '\n';
    const Folder folder(text);
    const BlockTable without_stars = BlockTable::load(folder.path);

    std::ifstream in(fs::path(TERRAVOX_SOURCE_DIR) / "tests/fixtures/minecraft/block_names.txt");
    std::string name;
    std::string unknown;
    std::string starred;
    int count = 0;
    while (std::getline(in, name)) {
        ++count;
        if (!appearance("minecraft:" + name).known)
            unknown += " " + name;
        const bool renamed = name == "grass" || name == "sign" || name == "wall_sign" ||
                             name == "prismarine_bricks_slab";
        if (!renamed && !without_stars.of(name, {}).known)
            starred += " " + name;
    }
    CHECK(count > 1100);
    CHECK(unknown == "");
    CHECK(starred == "");
}

TEST_CASE("every number that a block had in 1.12 is known, with any data", "[minecraft][blocks]") {
    for (int id = 0; id < 256; ++id)
        for (int data = 0; data < 16; ++data) {
            INFO(id << ":" << data);
            const bool never = id == 253 || id == 254;
            CHECK(shipped().of_number(id, data).known == !never);
            CHECK((shipped().name_of_number(id, data) ==
                   std::to_string(id) + ":" + std::to_string(data)) == never);
        }
    CHECK_FALSE(shipped().of_number(-1, 0).known);
    CHECK_FALSE(shipped().of_number(4095, 3).known);
    CHECK(shipped().of_number(4095, 3).material == Material::kUnknown);
    CHECK(shipped().name_of_number(4095, 19) == "4095:3");
}

TEST_CASE("blocks have the material that they look like, those of mods and versions to come, too",
          "[minecraft][blocks]") {
    struct Case {
        Material material;
        const char* states;
    };
    for (const Case& c : {
             Case{Material::kRock, "stone zinc_ore cinnabar_wall sulfur_spike"},
             Case{Material::kGrass, "grass_block"},
             Case{Material::kSoil, "dirt"},
             Case{Material::kSand, "sand"},
             Case{Material::kGround, "gravel"},
             Case{Material::kConcrete, "smooth_stone"},
             Case{Material::kTrunk,
                  "oak_log stripped_cherry_wood crimson_stem bamboo_block poplar_log "
                  "mod:stripped_ebony_log"},
             Case{Material::kHighVegetation,
                  "pale_oak_leaves red_poplar_leaves vine mod:ebony_leaves "
                  "mangrove_leaves[waterlogged=true]"},
             Case{Material::kMediumVegetation, "bamboo red_shrub"},
             Case{Material::kLowVegetation,
                  "pumpkin_stem tube_coral_fan[waterlogged=false] shelf_mushroom"},
             // Half a block or more stays itself in water.
             Case{Material::kWood,
                  "warped_planks bamboo_mosaic_stairs chest mod:ebony_planks "
                  "oak_slab[type=bottom,waterlogged=true] "
                  "oak_fence[waterlogged=true]"},
             Case{Material::kWater,
                  "water seagrass kelp_plant bubble_column "
                  "tube_coral_fan[waterlogged=true] rail[waterlogged=true] "
                  "iron_bars[waterlogged=true]"},
             Case{Material::kMasonry,
                  "stone_bricks nether_brick_fence cobblestone_wall furnace sulfur_brick_slab "
                  "mod:slate_brick_stairs"},
             Case{Material::kPlain,
                  "mushroom_stem light_blue_wool blue_terracotta red_wool_slab straw_bed "
                  "lime_concrete_stairs mod:ebony_wool_stairs chiseled_cinnabar "
                  "waxed_oxidized_cut_copper_stairs redstone_lamp[lit=false] "
                  "respawn_anchor[charges=0]"},
             Case{Material::kLava, "lava"},
             Case{Material::kGlass, "glass_pane tinted_glass"},
             Case{Material::kIce, "blue_ice"},
             Case{Material::kSnow, "snow[layers=4] snow[layers=8] snow_block"},
             Case{Material::kWire, "iron_bars waxed_copper_bars"},
             Case{Material::kLamp,
                  "lantern wall_torch furnace[lit=true] redstone_lamp[lit=true] "
                  "candle[lit=true] respawn_anchor[charges=4]"},
             Case{Material::kAir,
                  "redstone_torch[lit=false] candle[lit=false,candles=3] "
                  "snow[layers=3] oak_button powered_rail red_carpet "
                  "potted_cactus light void_air ebony_wall_hanging_sign"},
             Case{Material::kUnknown, "mod:gadget"},
         }) {
        std::istringstream states(c.states);
        for (std::string state; states >> state;) {
            INFO(state);
            const BlockAppearance found = appearance(state);
            CHECK(voxel::material_name(found.material) == voxel::material_name(c.material));
            CHECK(found.known == (c.material != Material::kUnknown));
        }
    }
    CHECK_FALSE(shipped().of("", {}).known);
}

TEST_CASE("old names and numbers mean what they meant", "[minecraft][blocks]") {
    std::istringstream rows(R"(
        1 0 stone  1 5 andesite  2 0 grass_block  2 7 grass_block  5 5 dark_oak_planks
        5 14 oak_planks  17 5 spruce_log  17 14 birch_log  18 15 jungle_leaves  31 1 short_grass
        35 14 red_wool  43 8 smooth_stone  44 9 sandstone_slab  62 3 furnace[lit=true]
        75 5 redstone_torch[lit=false]  78 0 snow[layers=1]  78 7 snow[layers=8]
        95 11 blue_stained_glass  97 2 infested_stone_bricks  118 2 water_cauldron
        162 5 dark_oak_log  175 8 sunflower  181 8 smooth_red_sandstone  251 4 yellow_concrete)");
    int id = 0;
    int data = 0;
    int count = 0;
    for (std::string name; rows >> id >> data >> name; ++count) {
        INFO(id << ":" << data);
        CHECK(shipped().name_of_number(id, data) == name);
        CHECK(shipped().of_number(id, data) == appearance(name));
    }
    CHECK(count == 24);
    CHECK(appearance("grass") == appearance("short_grass"));
    CHECK(appearance("sign") == appearance("oak_sign"));
    CHECK(appearance("lit_furnace").material == Material::kLamp);
    CHECK(appearance("unlit_redstone_torch[facing=up]").material == Material::kAir);
}

TEST_CASE("words give names and colours; more own letters go first, names before stars",
          "[minecraft][blocks]") {
    const Folder folder(R"(
waterlogged = ["wire"]
[words]
kind = ["", "_slab"]
[words.dye]
red = "#ff0000"
blue = "#0000ff"
[plain]
"{dye}_box{kind}" = "{dye}"
"*_box" = "#101010"
[rock]
"blue_box" = "#202020"
"big_*_box" = ""
"(a|b|{dye}|)_c[x=1|2,y=3]" = "#303030"
[soil]
"(a|b)_c[x=1]" = ""
[wire]
"bar" = "#404040"
)",
                        R"(
[renamed]
"old" = "a_c[x=2,y=3]"
[numbers]
7 = ["bar", "red_box", "blue_box"]
)");
    const BlockTable table = BlockTable::load(folder.path);
    const auto rgb = [&](const char* name) { return table.of(name, {}).colour; };
    CHECK(rgb("red_box") == voxel::Rgb8{255, 0, 0});
    CHECK(rgb("blue_box_slab") == voxel::Rgb8{0, 0, 255});
    CHECK(table.of("blue_box", {}).material == Material::kRock);
    CHECK(table.of("green_box", {}).material == Material::kPlain);
    CHECK(table.of("big_green_box", {}) == BlockAppearance{Material::kRock, false, {}, true});
    const std::array<Property, 2> both = {Property{"y", "3"}, Property{"x", "1"}};
    CHECK(table.of("a_c", both).material == Material::kRock);
    CHECK(table.of("_c", both).material == Material::kRock);
    CHECK(table.of("red_c", both).material == Material::kRock);
    CHECK(table.of("a_c", std::span(both).subspan(1)).material == Material::kSoil);
    CHECK_FALSE(table.of("a_c", std::span(both).first(1)).known);
    CHECK(table.of("old", {}).material == Material::kRock);
    const std::array<Property, 1> wet = {Property{"waterlogged", "true"}};
    CHECK(table.of("bar", wet).material == Material::kWater);
    CHECK(table.of("red_box", wet).material == Material::kPlain);
    CHECK(table.of_number(7, 6).material == Material::kRock);
    CHECK(table.name_of_number(7, 3) == "bar");
    CHECK_FALSE(table.of_number(8, 0).known);
}

TEST_CASE("a side-car's blocks go before the table's", "[minecraft][blocks]") {
    BlockTable table = BlockTable::load(kShipped);
    table.overlay({{"minecraft:white_terracotta", Material::kWall},
                   {"glass_pane", Material::kRoof},
                   {"grass", Material::kSnow},
                   {"mod:x", Material::kRail}});
    const BlockAppearance wall = table.of("minecraft:white_terracotta", {});
    CHECK(wall.material == Material::kWall);
    CHECK(wall.colour == appearance("white_terracotta").colour);
    CHECK(wall.has_colour);
    const std::array<Property, 1> wet = {Property{"waterlogged", "true"}};
    CHECK(table.of("glass_pane", wet).material == Material::kRoof);
    CHECK(table.of("grass", {}).material == Material::kSnow);
    CHECK(table.of("short_grass", {}).material == Material::kLowVegetation);
    CHECK(table.of("x", {}).material == Material::kRail);
    CHECK(table.of("x", {}).known);
}

TEST_CASE("bad tables are refused by file, entry, value and what is allowed",
          "[minecraft][blocks]") {
    struct Case {
        const char* blocks;
        const char* says;
        const char* old = "";
    };
    const char* const kA = "[rock]\na = \"\"";
    const auto c = GENERATE_COPY(values<Case>({
        {"[stuff]\nx = \"\"", "'stuff' is no material; allowed: "},
        {"rock = 3", "rock = 3"},
        {"[rock]\nx = \"#12\"", "[rock] \"x\" = '#12'"},
        {"[rock]\nx = 3", "[rock] \"x\" = 3"},
        {"[rock]\n\"{dye}_x\" = \"\"", "none of [words]"},
        {"[rock]\n\"a{dye\" = \"\"", "does not close its {"},
        {"[rock]\n\"a)\" = \"\"", "closes what it does not open"},
        {"[rock]\n\"((a))\" = \"\"", "has ( inside of ()"},
        {"[rock]\n\"a[lit]\" = \"\"", "'lit' is no condition"},
        {"[rock]\n\"a[lit=true\" = \"\"", "lacks its last ']'"},
        {"[rock]\n\"[a=1]\" = \"\"", "names no block"},
        {"[words]\nk = [\"a\"]\n[rock]\n\"{k}\" = \"{k}\"", "= '{k}'"},
        {"[words.k]\na = \"blue\"", "[words] k.a = 'blue'"},
        {"[words]\nk = 3", "[words] k = 3"},
        {"[rock]\n\"(a|b)\" = \"\"\n[soil]\n\"(b|c)\" = \"\"", "[rock] and [soil]"},
        {"[words]\nk = [\"a\",\"b\",\"c\",\"d\",\"e\",\"f\",\"g\",\"h\"]\n"
         "[rock]\n\"{k}{k}{k}{k}{k}\" = \"\"",
         "more than 4096 names"},
        {"waterlogged = [\"mud\"]", "'mud' is no material"},
        {"[rock\n", "line"},
        {kA, "[renamed] 'c' is none of blocks.toml", "[renamed]\nb = \"c\""},
        {kA, "[renamed] 'a' is a block", "[renamed]\na = \"a\""},
        {kA, "leaves x open", "[renamed]\nb = \"a[x=1|2]\""},
        {kA, "0 to 255", "[numbers]\n256 = [\"a\"]"},
        {kA, "[numbers] 6 = 'a'", "[numbers]\n6 = \"a\""},
        {kA, "1 to 16 names", "[numbers]\n6 = []"},
        {kA, "'more' is no part", "[more]\n"},
    }));
    INFO(c.blocks << c.old);
    const Folder folder(c.blocks, c.old);
    CHECK_THROWS_WITH((void)BlockTable::load(folder.path),
                      test::contains(c.says) &&
                          test::contains(*c.old == 0 ? "/blocks.toml" : "/old-blocks.toml"));
    CHECK_THROWS_WITH((void)BlockTable::load("/nowhere"),
                      test::contains("/nowhere/blocks.toml: no such file"));
}

TEST_CASE("stars fit as the plain way of trying all cuts does", "[minecraft][blocks]") {
    struct Slow {
        static bool fits(std::string_view p, std::string_view n) {
            if (p.empty())
                return n.empty();
            if (p[0] != '*')
                return !n.empty() && n[0] == p[0] && fits(p.substr(1), n.substr(1));
            for (std::size_t i = 0; i <= n.size(); ++i)
                if (fits(p.substr(1), n.substr(i)))
                    return true;
            return false;
        }
    };
    std::mt19937 random(7);
    for (int i = 0; i < 20000; ++i) {
        std::string pattern;
        std::string name;
        for (auto n = random() % 7; n > 0; --n)
            pattern += "ab*"[random() % 3];
        for (auto n = random() % 9; n > 0; --n)
            name += "ab"[random() % 2];
        INFO(pattern << " " << name);
        REQUIRE(fits(pattern, name) == Slow::fits(pattern, name));
    }
}

TEST_CASE("a table of another game is one file, and its names keep their namespace",
          "[minecraft][blocks]") {
    const Folder folder("[rock]\n\"(a|b):stone\" = \"#102030\"\n[sand]\n\"*:sand\" = \"\"\n");
    fs::remove(folder.path / "old-blocks.toml");
    const BlockTable table = BlockTable::load_names(folder.path / "blocks.toml");
    CHECK(table.of_full_name("a:stone").material == Material::kRock);
    CHECK(table.of_full_name("b:stone").colour == voxel::Rgb8{0x10, 0x20, 0x30});
    CHECK(table.of_full_name("c:sand").material == Material::kSand);
    CHECK_FALSE(table.of_full_name("c:stone").known);
    CHECK_FALSE(table.of_full_name("stone").known);
    CHECK_FALSE(table.of_number(1, 0).known);
}
