#include <cstdio>
#include <fstream>
#include <functional>
#include <iterator>
#include <random>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/voxelserver/make/worlds/luanti/made_luanti.hpp"
#include "tests/voxelserver/make/worlds/luanti/made_map_block.hpp"
#include "voxelserver/make/worlds/luanti/map_block.hpp"
#include "voxelserver/make/worlds/luanti/map_database.hpp"

namespace terravox::luanti {
namespace {

namespace fs = std::filesystem;
using test::contains;
using test::TemporaryFolder;
using test::luanti::BigEndian;
using test::luanti::body_29;
using test::luanti::Bytes;
using test::luanti::deflated;
using test::luanti::find_voxel;
using test::luanti::MadeBlock;
using test::luanti::MadeMap;
using test::luanti::map_block_blob;
using test::luanti::node_bytes;
using test::luanti::open_made;
using test::luanti::Schema;
using test::luanti::to_sql;
using test::luanti::zstd_frame;
using voxel::Material;

MadeBlock two_kinds() {
    MadeBlock out;
    out.names = {"air", "default:stone"};
    out.set(1, 2, 3, 1);
    return out;
}

Bytes zstd_block(const Bytes& body) {
    BigEndian out;
    return out.u8(29).put(zstd_frame(body)).bytes;
}

TEST_CASE("a map block of any version holds the nodes that were stored", "[luanti]") {
    const int version = GENERATE(25, 26, 27, 28, 29);
    MadeBlock made;
    for (int i = 1; i < 300; ++i)
        made.names.push_back("mod:node_" + std::to_string(i));
    std::mt19937 random(7);
    for (std::uint16_t& id : made.ids)
        id = static_cast<std::uint16_t>(random() % made.names.size());
    MapBlockReader reader;
    const Bytes blob = map_block_blob(made, version);
    for (int again = 0; again < 2; ++again) {
        const MapBlock& block = reader.read(blob);
        CHECK(block.version == version);
        CHECK(block.ids == made.ids);
        REQUIRE(block.names.size() == made.names.size());
        for (std::size_t i = 0; i < made.names.size(); ++i) {
            CHECK(block.names[i].id == i);
            CHECK(block.names[i].name == made.names[i]);
        }
    }
}

TEST_CASE("a damaged map block is refused with its reason", "[luanti]") {
    const MadeBlock good = two_kinds();
    const Bytes body = body_29(good);
    const auto changed = [&](std::size_t at, std::uint8_t byte) {
        Bytes out = body;
        out.at(at) = byte;
        return zstd_block(out);
    };
    // Offsets in the body: flags 0, lighting 1, time 3, version of the names 7, their count 8, the
    // first name's id 10, length 12, text 14; the second's id 17, length 19, text 21; widths 34.
    MadeBlock long_name = good;
    long_name.names[1].assign(257, 'x');
    Bytes cut_zstd = zstd_block(body);
    cut_zstd.resize(cut_zstd.size() - 4);
    Bytes flipped = zstd_block(body);
    flipped[1] ^= 0xFF;
    const Bytes older = map_block_blob(good, 28);
    Bytes broken_zlib = older;
    broken_zlib[6] ^= 0xFF;
    BigEndian few_nodes;
    few_nodes.u8(28).u8(0).u16(0).u8(2).u8(2).put(deflated(Bytes(100)));
    BigEndian one_byte_ids;
    one_byte_ids.u8(28).u8(0).u16(0).u8(1).u8(2);
    BigEndian bomb;
    bomb.u8(29).put(zstd_frame(Bytes((std::size_t{16} << 20) + 1)));
    BigEndian older_bomb;
    older_bomb.u8(28).u8(0).u16(0).u8(2).u8(2).put(deflated(node_bytes(good)));
    older_bomb.put(deflated(Bytes((std::size_t{16} << 20) + 1)));
    struct Case {
        const char* name;
        Bytes blob;
        const char* reason;
    };
    const std::vector<Case> cases = {
        {"no bytes", {}, "ends too early"},
        {"the version alone", {29}, "broken zstd data"},
        {"older than names", {24, 0, 0}, "format version 24; allowed: 25 to 29"},
        {"newer", {30, 0, 0}, "format version 30; allowed: 25 to 29"},
        {"a frame that is none", flipped, "broken zstd data"},
        {"a frame cut short", cut_zstd, "broken zstd data: it ends within its frame"},
        {"names of another version", changed(7, 1), "the version of the node names is 1"},
        {"too many names", changed(8, 0x20), "names 8194 nodes; allowed: up to 4096"},
        {"an empty name", changed(13, 0), "a node name of 0 bytes; allowed: 1 to 256"},
        {"a long name", zstd_block(body_29(long_name)), "a node name of 257 bytes"},
        {"an id named twice", changed(18, 0), "names node id 0 twice"},
        {"narrow ids", changed(34, 1), "the width of node ids is 1; allowed: 2"},
        {"wide parameters", changed(35, 3), "the width of node parameters is 3; allowed: 2"},
        {"nodes that end", zstd_block(Bytes(body.begin(), body.begin() + 9000)), "ends too early"},
        {"a bomb", bomb.bytes, "decompresses to more than 16 MiB; allowed: up to that"},
        {"an older one of narrow ids", one_byte_ids.bytes, "the width of node ids is 1"},
        {"an older one that is broken", broken_zlib, "broken zlib data"},
        {"an older one of few nodes", few_nodes.bytes, "node data of 100 bytes; allowed: 16384"},
        {"an older bomb", older_bomb.bytes, "decompresses to more than 16 MiB"},
        {"an older one without names", Bytes(older.begin(), older.end() - 40), "ends too early"},
    };
    for (const Case& c : cases) {
        INFO(c.name);
        MapBlockReader reader;
        CHECK_THROWS_WITH(reader.read(c.blob), contains(c.reason));
        CHECK(reader.read(map_block_blob(good, 29)).ids == good.ids);
    }
}

TEST_CASE("no cut or changed byte of a map block leads a reader astray", "[luanti]") {
    const int version = GENERATE(28, 29);
    const Bytes good = map_block_blob(two_kinds(), version);
    MapBlockReader reader;
    std::mt19937 random(11);
    for (std::size_t i = 0; i < good.size(); ++i) {
        Bytes cut(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(i));
        Bytes changed = good;
        changed[i] ^= static_cast<std::uint8_t>(1 + random() % 255);
        for (const Bytes& blob : {cut, changed}) {
            try {
                const std::size_t names = reader.read(blob).names.size();
                CHECK(names <= kBlockNodes);
            } catch (const util::Error&) {  // the right answer to a damaged block
            }
        }
    }
}

MadeBlock stone() {
    MadeBlock out;
    out.names.push_back("default:stone");
    out.ids.fill(1);
    return out;
}

std::ptrdiff_t files_in(const fs::path& folder) {
    return std::distance(fs::directory_iterator(folder), fs::directory_iterator());
}

/// Puts a block into a map, at x.
using Insert = std::function<void(int x)>;

TEST_CASE("a damaged map block is air, named with its place and reason, and the rest is there",
          "[luanti]") {
    MadeBlock nameless = stone();
    nameless.ids[77] = 9;
    struct Case {
        const char* name;
        Bytes blob;
        const char* line;
    };
    const std::vector<Case> cases = {
        {"of a version to come", {31, 1, 2}, "map block (0, 0, 1): format version 31"},
        {"cut short", {29, 0x28, 0xB5}, "map block (0, 0, 1): broken zstd data"},
        {"a node without a name", map_block_blob(nameless, 29),
         "map block (0, 0, 1): node id 9 has no name"},
        {"of no bytes", {}, "map block (0, 0, 1): no bytes are stored"},
    };
    for (const Case& c : cases) {
        INFO(c.name);
        const TemporaryFolder folder;
        {
            MadeMap map(folder.path() / "map.sqlite", Schema::kXyz);
            map.put(0, 0, 0, map_block_blob(stone(), 29));
            map.put(0, 0, 1, c.blob);
            map.put(0, 0, 2, map_block_blob(stone(), 28));
        }
        const auto world = open_made(folder.path() / "map.sqlite");
        CHECK(find_voxel(*world, 0, 0, -1) == Material::kRock);
        CHECK(find_voxel(*world, 0, 0, -17) == Material::kAir);
        CHECK(find_voxel(*world, 0, 0, -33) == Material::kRock);
        REQUIRE(world->damage().size() == 1);
        CHECK_THAT(world->damage().front(), contains(c.line));
    }
}

TEST_CASE("keys that stand for no place are counted, and the rest is there", "[luanti]") {
    const Schema schema = GENERATE(Schema::kEncoded, Schema::kXyz);
    const TemporaryFolder folder;
    {
        MadeMap map(folder.path() / "map.sqlite", schema);
        map.put(0, 0, 0, map_block_blob(stone(), 29));
        if (schema == Schema::kEncoded) {
            map.run("INSERT INTO blocks VALUES (9223372036854775807, x'1d')");
            map.run("INSERT INTO blocks VALUES (-9223372036854775807 - 1, x'1d')");
            map.run("INSERT INTO blocks VALUES ('here', x'1d')");
        } else {
            map.run("INSERT INTO blocks VALUES (2048, 0, 0, x'1d')");
            map.run("INSERT INTO blocks VALUES (0, -2049, 0, x'1d')");
            map.run("INSERT INTO blocks VALUES (0, 0, 'here', x'1d')");
        }
    }
    const auto world = open_made(folder.path() / "map.sqlite");
    CHECK(find_voxel(*world, 0, 0, -1) == Material::kRock);
    REQUIRE(world->damage().size() == 1);
    CHECK_THAT(world->damage().front(), contains("3 blocks have keys that stand for no place"));
}

TEST_CASE("a map of which nothing can be read is refused", "[luanti]") {
    const TemporaryFolder folder;
    const fs::path file = folder.path() / "map.sqlite";
    struct Case {
        const char* name;
        const char* sql;  ///< makes the file; empty: a text
        const char* reason;
    };
    const std::vector<Case> cases = {
        {"a text", "", "file is not a database"},
        {"no table", "CREATE TABLE other (a)", "no blocks of a known form"},
        {"no key", "CREATE TABLE blocks (pos INTEGER, data BLOB)", "no blocks of a known form"},
        {"part of a key", "CREATE TABLE blocks (x INTEGER PRIMARY KEY, y INT, z INT, data BLOB)",
         "no blocks of a known form"},
        {"no data", "CREATE TABLE blocks (pos INTEGER PRIMARY KEY)", "no blocks of a known form"},
        {"a view", "CREATE VIEW blocks AS SELECT 1 AS pos, x'1d' AS data",
         "no blocks of a known form"},
        {"no blocks", "CREATE TABLE blocks (pos INTEGER PRIMARY KEY, data BLOB)",
         "it has no map blocks; allowed: at least one"},
        {"damaged blocks",
         "CREATE TABLE blocks (pos INTEGER PRIMARY KEY, data BLOB);"
         "INSERT INTO blocks VALUES (0, x'1f'), (1, x'1e')",
         "none of its map blocks can be read; the first reason: map block (0, 0, 0): format "
         "version 31"},
        {"numbers for bytes",
         "CREATE TABLE blocks (pos INTEGER PRIMARY KEY, data BLOB);"
         "INSERT INTO blocks VALUES (0, 29)",
         "no bytes are stored"},
    };
    for (const Case& c : cases) {
        INFO(c.name);
        fs::remove(file);
        if (*c.sql == '\0') {
            std::ofstream(file) << std::string(4096, 'x');
        } else {
            test::Database(file).run(c.sql);
        }
        CHECK_THROWS_WITH(open_made(file), contains(c.reason));
    }
}

TEST_CASE("a map that a server writes to is read as it is, and the server goes on", "[luanti]") {
    const char* const mode = GENERATE("DELETE", "WAL");
    const TemporaryFolder folder;
    const fs::path file = folder.path() / "map.sqlite";
    {
        const MadeMap map(file, Schema::kXyz);
    }
    test::Database server(file);
    const std::string block = to_sql(map_block_blob(stone(), 29));
    server.run(std::string("PRAGMA journal_mode = ") + mode);
    server.run("INSERT INTO blocks VALUES (0, 0, 0, " + block + ")");
    const auto world = open_made(file);
    CHECK(find_voxel(*world, 0, 0, -1) == Material::kRock);
    server.run("INSERT INTO blocks VALUES (1, 0, 0, " + block + ")");
    CHECK(find_voxel(*world, 0, 1, -1) == Material::kRock);
    CHECK(world->damage().empty());
}

TEST_CASE("a map that is closed in WAL mode is read without a file next to it", "[luanti]") {
    const TemporaryFolder folder;
    const fs::path file = folder.path() / "map.sqlite";
    const Bytes block = map_block_blob(stone(), 29);
    {
        const MadeMap map(file, Schema::kXyz);
    }
    const auto serve = [&](const std::function<void(const Insert&)>& during) {
        test::Database server(file);
        server.run("PRAGMA journal_mode = WAL");
        during([&](int x) {
            server.run("INSERT INTO blocks VALUES (" + std::to_string(x) + ", 0, 0, " +
                       to_sql(block) + ")");
        });
    };
    const auto place = [](int x) { return BlockPlace{x, 0, mirrored(0)}; };
    serve([](const Insert& insert) { insert(0); });
    REQUIRE(files_in(folder.path()) == 1);
    MapDatabase map(file);
    std::size_t count = 0;
    CHECK(map.for_each_place([&](const BlockPlace&) { ++count; }) == 0);
    CHECK(count == 1);
    CHECK(map.read(place(0)) == block);
    CHECK(files_in(folder.path()) == 1);

    SECTION("and read anew after its server has written to it") {
        serve([](const Insert& insert) { insert(1); });
        CHECK(map.read(place(1)) == block);
        CHECK(files_in(folder.path()) == 1);
    }
    SECTION("and read while its server writes to it") {
        serve([&](const Insert& insert) {
            for (int x = 1; x < 3; ++x) {
                insert(x);
                CHECK(map.read(place(x)) == block);
            }
        });
        CHECK(map.read(place(2)) == block);
    }
    SECTION("but not without what a server that was killed has left in its log") {
        const fs::path copy = folder.path() / "copy";
        serve([&](const Insert& insert) {
            insert(1);
            fs::create_directory(copy);
            for (const char* const ending : {"", "-wal", "-shm"})
                fs::copy_file(file.string() + ending, copy / ("map.sqlite" + std::string(ending)));
        });
        CHECK(MapDatabase(copy / "map.sqlite").read(place(1)) == block);
        CHECK(files_in(copy) == 3);
        fs::remove(copy / "map.sqlite-shm");
        CHECK_THROWS_WITH(MapDatabase(copy / "map.sqlite"),
                          contains("it has a write-ahead log (-wal)") && contains("allowed: both"));
        CHECK(files_in(copy) == 2);
    }
}

}  // namespace
}  // namespace terravox::luanti
