#include <algorithm>
#include <filesystem>

#include "tests/catch.hpp"
#include "tests/voxelserver/make/worlds/minecraft/made_world.hpp"
#include "voxelserver/make/worlds/minecraft/world_info.hpp"

namespace terravox::minecraft {
namespace {

namespace fs = std::filesystem;
const fs::path kData = TERRAVOX_SHARED_DATA;

TEST_CASE("real worlds of every generation load, whole", "[raytracer][minecraft]") {
    struct Case {
        const char* path;
        const char* format;
        int chunks;
        int unfinished;
        std::int64_t blocks;
    };
    // Blocks as another reader counts them (docs/benchmarks/formats.md).
    const auto c = GENERATE(values<Case>(
        {{"mc-pymclevel/PyTestWorld", "McRegion", 445, 0, 7'326'144},
         {"mc-pymclevel/AnvilWorld", "Anvil", 583, 0, 10'144'291},
         {"mc-pymclevel/PrimordialDesert", "Anvil", 256, 0, 4'667'103},
         {"mc-pymclevel/TileTicks_chunks", "Alpha", 289, 0, 4'689'276},
         {"mc-prismarine/1.8.9", "Anvil", 300, 0, 4'948'489},
         {"mc-prismarine/1.12.2", "Anvil", 105, 0, 1'751'731},
         {"mc-prismarine/1.13.2", "Anvil", 189, 114, 3'137'732},
         {"mc-prismarine/1.16", "Anvil", 253, 0, 5'082'508},
         {"mc-prismarine/1.18.2", "Anvil", 280, 253, 1'701'238},
         {"mc-prismarine/1.20.6", "Anvil", 225, 209, 1'062'650},
         {"mc-fastanvil-crate/resources/1.19.4.mca", "Anvil", 676, 451, 8'896'316},
         {"mc-fastanvil-crate/resources/1.17.1-custom-heights.chunk", "one chunk", 1, 0, 47'821}}));
    if (!fs::exists(kData / c.path)) {
        WARN("the shared data are not here: " << c.path);
        return;
    }
    INFO(c.path);
    const WorldFacts facts = describe(kData / c.path, "overworld", true, 2);
    const DimensionFacts& world = facts.dimensions.at(0);
    CHECK(facts.format == c.format);
    CHECK(world.chunks == c.chunks);
    CHECK(world.unfinished == c.unfinished);
    CHECK(world.damaged == 0);
    std::int64_t blocks = 0;
    for (const auto& [name, count] : world.blocks)
        blocks += count;
    CHECK(blocks == c.blocks);
    CHECK_THAT(to_text(facts, &test::shipped_blocks()),
               test::contains("chunks: " + std::to_string(c.chunks)));
    CHECK_THAT(to_json(facts), test::contains("\"format\": \"" + std::string(c.format)));
}

TEST_CASE("the names of a world do not speak to the terminal", "[raytracer][minecraft]") {
    WorldFacts facts;
    facts.level.emplace();
    facts.level->name = "level \x1b[2J";
    facts.level->version = "version \xe2\x80\xae";  // U+202E turns around what follows
    DimensionFacts dimension;
    dimension.name = "DIM\x1b";
    dimension.blocks["mod:\x1b]0;title\x07"] = 2;
    dimension.notes = {"note \xc2\x9b"};
    facts.dimensions = {dimension};
    const std::string text = to_text(facts, nullptr);
    const auto is_plain = [](char c) { return c == '\n' || (c >= ' ' && c <= '~'); };
    CHECK(std::ranges::all_of(text, is_plain));
    CHECK_THAT(text, test::contains("level \\x1b[2J") && test::contains("mod:\\x1b]0;title\\x07"));
    CHECK(std::ranges::all_of(to_json(facts), is_plain));
}

}  // namespace
}  // namespace terravox::minecraft
