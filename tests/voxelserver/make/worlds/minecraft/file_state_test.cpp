#include "voxelserver/make/worlds/minecraft/minecraft_world.hpp"

#include <chrono>
#include <filesystem>
#include <fstream>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"

using namespace terravox;
using terravox::test::TemporaryFolder;
namespace fs = std::filesystem;

namespace {

void write(const fs::path& file, const char* text) {
    fs::create_directories(file.parent_path());
    std::ofstream(file) << text;
}

}  // namespace

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
        write(at / "world" / "level.dat", "level");
        write(at / "world" / "region" / "r.0.0.mca", "region");
        write(at / "blocks" / "all.toml", "blocks");
        const auto state = [&] { return minecraft::file_state(at / "world", at / "blocks"); };
        const voxel::Fingerprint before = state();
        CHECK(state() == before);
        write(at / c.written, "something else");
        CHECK((state() != before) == c.changes);
    }
}

TEST_CASE("a world that is one file has the state of the file", "[voxelserver][minecraft]") {
    const TemporaryFolder folder;
    const fs::path zip = folder.path() / "world.zip";
    write(zip, "ZIP");
    write(folder.path() / "blocks" / "all.toml", "blocks");
    const auto state = [&] { return minecraft::file_state(zip, folder.path() / "blocks"); };
    const voxel::Fingerprint before = state();
    fs::last_write_time(zip, fs::last_write_time(zip) + std::chrono::seconds(1));
    CHECK(state() != before);
    fs::remove(zip);
    CHECK_THROWS_AS(state(), util::Error);
}
