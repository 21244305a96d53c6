#include <cstdio>
#include <fstream>
#include <functional>
#include <iterator>
#include <random>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/voxelserver/make/worlds/luanti/made_luanti.hpp"
#include "voxelserver/make/worlds/luanti/map_database.hpp"

namespace terravox::luanti {
namespace {

namespace fs = std::filesystem;
using test::contains;
using test::TemporaryFolder;
using test::luanti::Bytes;
using test::luanti::find_voxel;
using test::luanti::MadeBlock;
using test::luanti::MadeMap;
using test::luanti::map_block_blob;
using test::luanti::open_made;
using test::luanti::Schema;
using voxel::Material;

MadeBlock stone() {
    MadeBlock out;
    out.names.push_back("default:stone");
    out.ids.fill(1);
    return out;
}

std::string to_hex(const Bytes& bytes) {
    std::string out;
    for (const std::uint8_t byte : bytes) {
        char digits[3];
        std::snprintf(digits, sizeof digits, "%02x", byte);
        out += digits;
    }
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
            sqlite3* database = nullptr;
            REQUIRE(sqlite3_open(file.string().c_str(), &database) == SQLITE_OK);
            REQUIRE(sqlite3_exec(database, c.sql, nullptr, nullptr, nullptr) == SQLITE_OK);
            sqlite3_close(database);
        }
        CHECK_THROWS_WITH(open_made(file), contains(c.reason));
    }
}

TEST_CASE("a map that a server writes to is read as it is, and the server goes on", "[luanti]") {
    const char* const mode = GENERATE("DELETE", "WAL");
    const TemporaryFolder folder;
    const fs::path file = folder.path() / "map.sqlite";
    sqlite3* server = nullptr;
    {
        const MadeMap map(file, Schema::kXyz);
    }
    REQUIRE(sqlite3_open(file.string().c_str(), &server) == SQLITE_OK);
    const auto run = [&](const std::string& sql) {
        return sqlite3_exec(server, sql.c_str(), nullptr, nullptr, nullptr);
    };
    REQUIRE(run(std::string("PRAGMA journal_mode = ") + mode) == SQLITE_OK);
    const std::string hex = to_hex(map_block_blob(stone(), 29));
    REQUIRE(run("INSERT INTO blocks VALUES (0, 0, 0, x'" + hex + "')") == SQLITE_OK);
    const auto world = open_made(file);
    CHECK(find_voxel(*world, 0, 0, -1) == Material::kRock);
    CHECK(run("INSERT INTO blocks VALUES (1, 0, 0, x'" + hex + "')") == SQLITE_OK);
    CHECK(find_voxel(*world, 0, 1, -1) == Material::kRock);
    CHECK(world->damage().empty());
    sqlite3_close(server);
}

TEST_CASE("a map that is closed in WAL mode is read without a file next to it", "[luanti]") {
    const TemporaryFolder folder;
    const fs::path file = folder.path() / "map.sqlite";
    const Bytes block = map_block_blob(stone(), 29);
    {
        const MadeMap map(file, Schema::kXyz);
    }
    const auto serve = [&](const std::function<void(const Insert&)>& during) {
        sqlite3* server = nullptr;
        REQUIRE(sqlite3_open(file.string().c_str(), &server) == SQLITE_OK);
        const auto run = [&](const std::string& sql) {
            REQUIRE(sqlite3_exec(server, sql.c_str(), nullptr, nullptr, nullptr) == SQLITE_OK);
        };
        run("PRAGMA journal_mode = WAL");
        during([&](int x) {
            run("INSERT INTO blocks VALUES (" + std::to_string(x) + ", 0, 0, x'" + to_hex(block) +
                "')");
        });
        sqlite3_close(server);
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

TEST_CASE("no changed byte of a map.sqlite does more than damage", "[luanti]") {
    const TemporaryFolder folder;
    const fs::path file = folder.path() / "map.sqlite";
    {
        MadeMap map(file, Schema::kEncoded);
        for (int x = 0; x < 4; ++x)
            map.put(x, 0, 0, map_block_blob(stone(), 28));
    }
    std::ifstream in(file, std::ios::binary);
    const std::string good{std::istreambuf_iterator<char>(in), {}};
    std::mt19937 random(5);
    for (int i = 0; i < 120; ++i) {
        std::string bytes = good;
        const std::size_t at = random() % bytes.size();
        bytes[at] = static_cast<char>(random());
        CAPTURE(at);
        std::ofstream(file, std::ios::binary) << bytes;
        try {
            const auto world = open_made(file);
            (void)find_voxel(*world, 0, 0, -1);
        } catch (const util::Error&) {  // the right answer to a file that cannot be read
        }
    }
}

}  // namespace
}  // namespace terravox::luanti
