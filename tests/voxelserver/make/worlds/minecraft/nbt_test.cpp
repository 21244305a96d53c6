#include <algorithm>
#include <filesystem>
#include <random>

#include "tests/catch.hpp"
#include "tests/voxelserver/make/worlds/minecraft/made_files.hpp"
#include "tests/voxelserver/make/worlds/minecraft/made_world.hpp"
#include "voxelserver/make/worlds/minecraft/inflate.hpp"
#include "voxelserver/make/worlds/minecraft/nbt.hpp"
#include "voxelserver/make/worlds/minecraft/world_folder.hpp"
#include "voxelserver/make/worlds/minecraft/world_info.hpp"

namespace terravox::minecraft {
namespace {

namespace fs = std::filesystem;
using test::Bytes;
using test::NbtWriter;

// Passes over a whole file.
void skip_file(const Bytes& bytes) {
    NbtReader in(bytes);
    in.enter_root();
    NbtField field;
    while (in.next(field))
        in.skip(field.type);
}

std::vector<std::pair<Compression, Bytes>> packed_in_each_way(const Bytes& raw) {
    return {{Compression::kGzip, test::deflated(raw, true)},
            {Compression::kZlib, test::deflated(raw, false)},
            {Compression::kNone, raw},
            {Compression::kLz4, test::lz4_blocks(raw)}};
}

TEST_CASE("NBT is pulled field by field, in any order, by type", "[raytracer][minecraft]") {
    NbtWriter made;
    made.compound("root")
        .number8("byte", -3)
        .number32("int", -70000)
        .number64("long", -5'000'000'000)
        .string("text", "a")
        .byte_array("bytes", {1, 2, 255});
    made.long_array("longs", {1, ~std::uint64_t{0}})
        .field(5, "float")
        .raw(0x3FC00000, 4)
        .field(6, "double")
        .raw(0xC000000000000000, 8);
    made.list("list", 2, 2)
        .raw(7, 2)
        .raw(0xFFFF, 2)
        .compound("inner")
        .number8("deep", 1)
        .end()
        .end();
    NbtReader in(made.bytes);
    in.enter_root();
    NbtField field;
    std::string seen;
    while (in.next(field)) {
        seen += std::string(field.name) + " ";
        if (field.name == "byte")
            CHECK(in.integer(field.type) == -3);
        else if (field.name == "int")
            CHECK(in.integer(field.type) == -70000);
        else if (field.name == "long")
            CHECK(in.integer(field.type) == -5'000'000'000);
        else if (field.name == "text")
            CHECK(in.string() == "a");
        else if (field.name == "bytes")
            CHECK(in.byte_array()[2] == 255);
        else if (field.name == "longs")
            CHECK(in.long_array()[1] == ~std::uint64_t{0});
        else if (field.name == "list") {
            const NbtList list = in.list();
            REQUIRE((list.type == NbtType::kShort && list.count == 2));
            CHECK(in.integer(list.type) == 7);
            CHECK(in.integer(list.type) == -1);
        } else
            in.skip(field.type);
    }
    CHECK(seen == "byte int long text bytes longs float double list inner ");
}

TEST_CASE("broken NBT is an error that names what is wrong", "[raytracer][minecraft]") {
    const auto root = [] { return NbtWriter().compound(""); };
    NbtWriter deep = root();
    NbtWriter deep_lists = root();
    for (int i = 0; i < 10'000; ++i)
        deep.compound("a");
    deep_lists.field(9, "a");
    for (int i = 0; i < 10'000; ++i)
        deep_lists.raw(9, 1).raw(1, 4);
    struct Case {
        const char* name;
        Bytes bytes;
        const char* message;
    };
    const std::vector<Case> cases = {
        {"nested 10,000 deep", deep.bytes, "deeper than 512"},
        {"lists nested 10,000 deep", deep_lists.bytes, "deeper than 512"},
        {"an array claims 2 GB", root().field(7, "a").raw(0x7FFFFFFF, 4).bytes,
         "a length of 2147483647"},
        {"longs claim 16 GB", root().field(12, "a").raw(0x7FFFFFFF, 4).bytes,
         "a length of 2147483647"},
        {"a negative length", root().field(11, "a").raw(0xFFFFFFFF, 4).bytes, "a length of -1"},
        {"a list claims 2^31 compounds", root().list("a", 10, 0x7FFFFFFF).bytes,
         "a list of 2147483647"},
        {"a list of elements without a type", root().list("a", 0, 5).raw(0, 8).bytes,
         "without a type"},
        {"a list of a type that is none", root().list("a", 13, 1).bytes, "type 13"},
        {"a field of a type that is none", root().field(77, "a").bytes, "type 77"},
        {"a string past the end", root().field(8, "a").raw(500, 2).bytes, "500 bytes wanted"},
        {"no end", root().number8("a", 1).bytes, "1 bytes wanted, 0 left"},
        {"a file of another type", NbtWriter().field(8, "").bytes, "a file of type 8"},
        {"nothing", {}, "1 bytes wanted"},
    };
    for (const Case& c : cases)
        DYNAMIC_SECTION(c.name) {
            CHECK_THROWS_WITH(skip_file(c.bytes), test::contains(c.message));
        }
    // At the limit, all is well.
    NbtWriter allowed = root();
    for (int i = 0; i < 512; ++i)
        allowed.compound("a");
    for (int i = 0; i < 513; ++i)
        allowed.end();
    CHECK_NOTHROW(skip_file(allowed.bytes));
}

TEST_CASE("NBT that is cut short anywhere is an error, never read past", "[raytracer][minecraft]") {
    NbtWriter made;
    made.compound("")
        .list("l", 10, 2)
        .number8("a", 1)
        .end()
        .string("b", "text")
        .end()
        .long_array("c", {1, 2, 3})
        .list("d", 8, 2)
        .text("x")
        .text("y")
        .end();
    CHECK_NOTHROW(skip_file(made.bytes));
    for (std::size_t size = 0; size < made.bytes.size(); ++size) {
        const Bytes cut(made.bytes.begin(),
                        made.bytes.begin() + static_cast<std::ptrdiff_t>(
                                                 size));  // a copy: what lies behind is not ours
        INFO("cut after " << size << " bytes");
        CHECK_THROWS_AS(skip_file(cut), NbtError);
    }
}

TEST_CASE("modified UTF-8 becomes UTF-8, and what is no text a question mark",
          "[raytracer][minecraft]") {
    CHECK(to_utf8("Gr\xC3\xBC\xC3\x9F") == "Gr\xC3\xBC\xC3\x9F");
    CHECK(to_utf8("\xED\xA0\xBD\xED\xB8\x80") == "\xF0\x9F\x98\x80");  // a pair of surrogates
    CHECK(to_utf8(std::string_view("a\xC0\x80z", 4)) == "a?z");
    CHECK(to_utf8("a\nb\x7F") == "a?b?");
    CHECK(to_utf8("\xFF\xC3") == "??");
    CHECK(to_utf8("\xED\xA0\xBD.") == "?.");
}

TEST_CASE("level.dat holds name, version, spawn and seed", "[raytracer][minecraft]") {
    const LevelDat level = read_level_dat(test::level_dat_nbt("Bled"), "level.dat");
    CHECK(level.name == "Bled");
    CHECK(level.version == "1.18.2");
    CHECK(level.data_version == 2975);
    CHECK(level.spawn == std::array<std::int64_t, 3>{8, 64, -8});
    CHECK(level.seed == -5);
    CHECK_THROWS_WITH(read_level_dat(Bytes{1, 2, 3}, "x/level.dat"), test::contains("x/level.dat"));
}

TEST_CASE("each kind of compression gives back what was packed", "[raytracer][minecraft]") {
    std::mt19937_64 random(1);
    Bytes raw(300'000);
    for (std::size_t i = 0; i < raw.size(); ++i)
        raw[i] = static_cast<std::uint8_t>(
            i < 200'000 ? i / 1000 : random());  // some packs well, some not at all
    Inflater inflater;
    for (int pass = 0; pass < 2; ++pass)
        for (const auto& [compression, packed] : packed_in_each_way(raw)) {
            INFO(compression_name(compression));
            const auto out = inflater.unpack(compression, packed);
            CHECK(Bytes(out.begin(), out.end()) == raw);
            CHECK(guess_compression(packed) == compression);
        }
    // More than the first buffer holds.
    const Bytes large(3'000'000, 7);
    CHECK(inflater.unpack(Compression::kZlib, test::deflated(large, false)).size() == large.size());
    CHECK(inflater.unpack(Compression::kLz4, test::lz4_blocks(large)).size() == large.size());
}

TEST_CASE("packed data that are broken, cut short or too large are an error",
          "[raytracer][minecraft]") {
    Bytes raw(100'000);
    for (std::size_t i = 0; i < raw.size(); ++i)
        raw[i] = static_cast<std::uint8_t>(i * i >> 7);
    Inflater inflater;
    for (const auto& [compression, packed] : packed_in_each_way(raw)) {
        if (compression == Compression::kNone)
            continue;
        INFO(compression_name(compression));
        Bytes cut(packed.begin(), packed.begin() + 500);
        Bytes flipped = packed;
        flipped[flipped.size() / 2] ^= 0x10;
        CHECK_THROWS_AS(inflater.unpack(compression, cut), InflateError);
        CHECK_THROWS_AS(inflater.unpack(compression, flipped), InflateError);
    }
    Bytes token = test::lz4_blocks(raw);
    token[8] = 0x46;
    CHECK_THROWS_AS(inflater.unpack(Compression::kLz4, token), InflateError);
    const Bytes bomb(Inflater::kLimitBytes + 1, 0);
    CHECK_THROWS_WITH(inflater.unpack(Compression::kZlib, test::deflated(bomb, false)),
                      test::contains("64 MiB"));
    CHECK_THROWS_WITH(inflater.unpack(Compression::kLz4, test::lz4_blocks(bomb, 1 << 22)),
                      test::contains("64 MiB"));
    CHECK_THROWS_WITH(inflater.unpack(Compression::kNone, bomb), test::contains("64 MiB"));
}

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
