#include "voxelserver/make/worlds/luanti/luanti_world.hpp"

#include <fstream>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"

namespace terravox::luanti {
namespace {

namespace fs = std::filesystem;
using test::contains;
using test::TemporaryFolder;

void write(const fs::path& file, const std::string& text) {
    fs::create_directories(file.parent_path());
    std::ofstream(file, std::ios::binary) << text;
}

TEST_CASE("a world is a folder with a world.mt, or a map.sqlite", "[luanti]") {
    const TemporaryFolder folder;
    const fs::path& at = folder.path();
    write(at / "plain" / "world.mt", "");
    write(at / "both" / "world.mt", "");
    write(at / "both" / "level.dat", "");
    write(at / "map" / "map.sqlite", "");
    write(at / "map" / "players.sqlite", "");
    CHECK(looks_like_luanti(at / "plain"));
    CHECK(looks_like_luanti(at / "map" / "map.sqlite"));
    CHECK_FALSE(looks_like_luanti(at / "both"));
    CHECK_FALSE(looks_like_luanti(at / "map"));
    CHECK_FALSE(looks_like_luanti(at / "map" / "players.sqlite"));
    CHECK_FALSE(looks_like_luanti(at / "none"));
}

TEST_CASE("a world's title is that of world.mt, else the folder's name", "[luanti]") {
    const TemporaryFolder folder;
    const fs::path world = folder.path() / "My World";
    write(world / "map.sqlite", "");
    CHECK(find_world_files(world / "map.sqlite").title == "My World");
    write(world / "world.mt", "gameid = minetest\r\nthis is no setting\nbackend = sqlite3");
    CHECK(find_world_files(world).title == "My World");
    CHECK(find_world_files(world).game == "minetest");
    write(world / "world.mt", "world_name =  Sol III \nbackend=sqlite3\n");
    CHECK(find_world_files(world).title == "Sol III");
    CHECK(find_world_files(world).map == world / "map.sqlite");
}

TEST_CASE("a world that keeps its map elsewhere is refused with what is allowed", "[luanti]") {
    struct Case {
        const char* name;
        const char* settings;
        const char* reason;
    };
    const auto c = GENERATE(values<Case>({
        {"leveldb", "backend = leveldb\n", "backend = leveldb in its world.mt; allowed: sqlite3"},
        {"postgresql", "backend = postgresql\n", "backend = postgresql"},
        {"redis", "backend = redis\n", "backend = redis"},
        {"dummy", "backend = dummy\n", "backend = dummy"},
        {"larger blocks", "blocksize = 32\n", "blocksize = 32 in its world.mt; allowed: 16"},
        {"never played", "backend = sqlite3\n", "no map.sqlite"},
    }));
    DYNAMIC_SECTION(c.name) {
        const TemporaryFolder folder;
        write(folder.path() / "world.mt", c.settings);
        CHECK_THROWS_AS(find_world_files(folder.path()), util::UsageError);
        CHECK_THROWS_WITH(find_world_files(folder.path()),
                          contains(folder.path().string()) && contains(c.reason));
    }
}

TEST_CASE("a world.mt of more than 1 MiB is refused", "[luanti]") {
    const TemporaryFolder folder;
    write(folder.path() / "map.sqlite", "");
    write(folder.path() / "world.mt", std::string((std::size_t{1} << 20) + 1, '\n'));
    CHECK_THROWS_WITH(find_world_files(folder.path()), contains("more than 1 MiB"));
}

}  // namespace
}  // namespace terravox::luanti
