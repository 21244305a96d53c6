#include <algorithm>
#include <chrono>
#include <filesystem>
#include <random>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/common/content.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/voxelserver/make/worlds/minecraft/made_world.hpp"
#include "voxelserver/make/worlds/minecraft/minecraft_world.hpp"
#include "voxelserver/make/worlds/minecraft/source.hpp"
#include "voxelserver/make/worlds/minecraft/world_info.hpp"

using namespace terravox;
using terravox::test::TemporaryFolder;
using terravox::test::write_content;
namespace fs = std::filesystem;

namespace terravox::minecraft {
namespace {

using test::Bytes;
using test::Made;
using test::MadeWorld;

TEST_CASE("a world in a ZIP file is the world in the folder, however deep it lies",
          "[raytracer][minecraft]") {
    struct Case {
        std::string at;
        bool with_level;
        const char* title;
    };
    const auto& [at, with_level, title] =
        GENERATE(values<Case>({{"", false, "world"},
                               {"My World/", true, "zipped"},
                               {"saves/old/My World/", false, "My World"}}));
    const MadeWorld made = test::random_world(2, -10, 30);
    std::map<std::string, Bytes> files;
    for (auto& [name, bytes] : made.files(Made::kFlat))
        files[at + name] = bytes;
    files[at + "entities/r.0.0.mca"] = Bytes(10, 1);
    if (with_level)
        files[at + "level.dat"] = test::level_dat_nbt("zipped");
    const TemporaryFolder folder;
    test::write_zip(folder.path() / "world.zip", files);
    INFO(at << (with_level ? " with" : " without") << " level.dat");
    const auto world = test::open_made(folder.path() / "world.zip");
    CHECK(test::differing_voxels(*world, made) == 0);
    CHECK(world->damage().empty());
    CHECK(world->info().title == title);
    CHECK(looks_like_minecraft(folder.path() / "world.zip"));
}

TEST_CASE("files of a ZIP file that lead outside are refused and named", "[raytracer][minecraft]") {
    const MadeWorld made = test::random_world(2, 0, 10);
    std::map<std::string, Bytes> files = made.files(Made::kFlat);
    const Bytes other = files.begin()->second;
    for (const char* name : {"../region/r.5.5.mca", "region/../../r.6.6.mca", "/region/r.7.7.mca",
                             "C:\\region\\r.8.8.mca"})
        files[name] = other;
    files[".\\region\\r.9.9.mca"] =
        other;  // a name of Windows, which is fine: its chunks stand at the wrong place, though
    const TemporaryFolder folder;
    test::write_zip(folder.path() / "world.zip", files);
    const WorldFacts facts = describe(folder.path() / "world.zip", "", false, 1);
    CHECK(facts.damage.size() == 4);
    for (const std::string& line : facts.damage)
        CHECK_THAT(line, test::contains("leads outside"));
    CHECK(facts.dimensions.at(0).files.at("mca") ==
          static_cast<int>(made.files(Made::kFlat).size()) + 1);
    const auto world = test::open_made(folder.path() / "world.zip");
    CHECK(test::differing_voxels(*world, made) == 0);
    CHECK(world->damage().size() > 4);
}

TEST_CASE(
    "a file of a ZIP file that unpacks to far more than itself is refused, and the rest is there",
    "[raytracer][minecraft]") {
    MadeWorld made;
    made.chunk(0, 0).set(1, 1, 1, 1);
    std::map<std::string, Bytes> files = made.files(Made::kFlat);
    Bytes bomb(std::size_t{80} << 20, 0);
    bomb[3] = 1;
    bomb[1] = 0x27;
    bomb[2] = 0x10;  // one chunk, far back
    files["region/r.1.0.mca"] = bomb;
    const TemporaryFolder folder;
    test::write_zip(folder.path() / "world.zip", files);
    CHECK(std::filesystem::file_size(folder.path() / "world.zip") < 1'000'000);
    const auto world = test::open_made(folder.path() / "world.zip");
    CHECK(test::differing_voxels(*world, made) == 0);
    REQUIRE(world->damage().size() == 1);
    CHECK_THAT(world->damage()[0], test::contains("more than 200 times its packed size"));
}

TEST_CASE("a large file of a ZIP file is unpacked to disk, and reads as it is",
          "[raytracer][minecraft][all]") {
    Bytes large(std::size_t{70} << 20);
    std::mt19937_64 random(1);
    for (std::size_t i = 0; i + 8 <= large.size(); i += 64)
        large[i] = static_cast<std::uint8_t>(random());
    const TemporaryFolder folder;
    test::write_zip(folder.path() / "a.zip", {{"large", large}, {"small", {1, 2, 3}}});
    const auto source = open_source(folder.path() / "a.zip", 1 << 20);
    REQUIRE(source->entries().size() == 2);
    const auto file = source->open(*source->find("large"));
    REQUIRE(file->size() == large.size());
    Bytes part(1000);
    for (const std::size_t at :
         {std::size_t{0}, std::size_t{66'000'000}, large.size() - part.size()}) {
        file->read(at, part);
        CHECK(
            std::equal(part.begin(), part.end(), large.begin() + static_cast<std::ptrdiff_t>(at)));
    }
    CHECK_THROWS_AS(file->read(large.size() - 10, part), util::Error);
    CHECK(source->head(*source->find("small"), 2) == Bytes{1, 2});
    CHECK(source->whole(*source->find("small"), 3) == Bytes{1, 2, 3});
    CHECK_THROWS_WITH(source->whole(*source->find("small"), 2),
                      test::contains("more than 2 bytes"));
    CHECK_FALSE(source->find("none"));
}

TEST_CASE("ZIP files that are none, cut short or without a world are an error",
          "[raytracer][minecraft]") {
    const TemporaryFolder folder;
    test::write_zip(folder.path() / "other.zip", {{"readme.txt", {1}}});
    CHECK_THROWS_WITH(test::open_made(folder.path() / "other.zip"),
                      test::contains("no level.dat and no chunks"));
    CHECK_FALSE(looks_like_minecraft(folder.path() / "other.zip"));
    test::write_zip(folder.path() / "whole.zip", test::random_world(1, 0, 20).files(Made::kFlat));
    const Bytes whole = test::read_bytes(folder.path() / "whole.zip");
    for (const std::size_t size : {whole.size() - 1, whole.size() / 2, std::size_t{4}}) {
        test::write_bytes(folder.path() / "cut.zip",
                          Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)));
        INFO(size);
        CHECK_THROWS_AS(test::open_made(folder.path() / "cut.zip"), util::Error);
    }
}

}  // namespace
}  // namespace terravox::minecraft

TEST_CASE("the state of a Minecraft world is that of the files with its blocks",
          "[voxelserver][minecraft]") {
    struct Case {
        const char* name;
        const char* written;  ///< within the folder
        bool changes;
    };
    const auto c = GENERATE(values<Case>({
        {"a region", "world/region/r.0.0.mca", true},
        {"another region", "world/region/r.1.0.mca", true},
        {"a region of the nether", "world/DIM-1/region/r.0.0.mca", true},
        {"a chunk outside of its region", "world/region/c.0.0.mcc", true},
        {"an Alpha chunk", "world/0/0/c.0.0.dat", true},
        {"the level", "world/level.dat", true},
        {"the side-car", "world/terravox.json", true},
        {"the block table", "blocks/stone.toml", true},
        {"entities", "world/entities/r.0.0.mca", false},
        {"points of interest", "world/poi/r.0.0.mca", false},
        {"a player", "world/playerdata/a.dat", false},
        {"the lock", "world/session.lock", false},
    }));
    DYNAMIC_SECTION(c.name) {
        const TemporaryFolder folder;
        const fs::path& at = folder.path();
        write_content(at / "world" / "level.dat", "level");
        write_content(at / "world" / "region" / "r.0.0.mca", "region");
        write_content(at / "blocks" / "all.toml", "blocks");
        const auto state = [&] { return minecraft::file_state(at / "world", at / "blocks"); };
        const voxel::Fingerprint before = state();
        CHECK(state() == before);
        write_content(at / c.written, "something else");
        CHECK((state() != before) == c.changes);
    }
}

TEST_CASE("a world that is one file has the state of the file", "[voxelserver][minecraft]") {
    const TemporaryFolder folder;
    const fs::path zip = folder.path() / "world.zip";
    write_content(zip, "ZIP");
    write_content(folder.path() / "blocks" / "all.toml", "blocks");
    const auto state = [&] { return minecraft::file_state(zip, folder.path() / "blocks"); };
    const voxel::Fingerprint before = state();
    fs::last_write_time(zip, fs::last_write_time(zip) + std::chrono::seconds(1));
    CHECK(state() != before);
    fs::remove(zip);
    CHECK_THROWS_AS(state(), util::Error);
}
