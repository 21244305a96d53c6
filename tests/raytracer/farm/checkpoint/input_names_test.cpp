#include "raytracer/farm/checkpoint/picture_key.hpp"

#include <fstream>
#include <functional>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"

using namespace terravox;
using namespace terravox::test;
namespace fs = std::filesystem;

namespace {

void write_text(const fs::path& file, const std::string& text) {
    fs::create_directories(file.parent_path());
    std::ofstream(file, std::ios::binary) << text;
}

/// A survey of two files in a folder, one of them larger than what is looked into.
void make_survey(const fs::path& folder) {
    write_text(folder / "a.laz", std::string(100'000, 'a'));
    write_text(folder / "deeper" / "b.laz", "b");
    write_text(folder / "empty.laz", "");
}

std::string to_name(const fs::path& input) {
    return farm::name_inputs({input.string()}, {}, {}).front();
}

}  // namespace

TEST_CASE("inputs are named by what is in them, not by where they lie",
          "[raytracer][checkpoint][inputs]") {
    const TemporaryFolder here, there;
    make_survey(here.path() / "survey");
    make_survey(there.path() / "survey");
    const std::string name = to_name(here.path() / "survey");
    CHECK_THAT(name, contains("survey: 3 files, 100001 bytes, "));
    CHECK(to_name(there.path() / "survey") == name);
    CHECK(to_name((there.path() / "survey").string() + "/") == name);
    fs::last_write_time(there.path() / "survey" / "a.laz",
                        fs::file_time_type::clock::now() - std::chrono::hours(9));
    write_text(there.path() / "survey" / ".hidden" / "x", "x");
    write_text(there.path() / "survey" / "session.lock", "x");
    write_text(there.path() / "survey" / "store.gpkg-wal", "x");
    CHECK(to_name(there.path() / "survey") == name);
}

TEST_CASE("inputs that changed have another name", "[raytracer][checkpoint][inputs]") {
    struct Case {
        const char* name;
        std::function<void(const fs::path&)> change;
    };
    const std::vector<Case> cases = {
        {"first byte",
         [](const fs::path& f) { write_text(f / "a.laz", "x" + std::string(99'999, 'a')); }},
        {"last byte",
         [](const fs::path& f) { write_text(f / "a.laz", std::string(99'999, 'a') + "x"); }},
        {"longer", [](const fs::path& f) { write_text(f / "a.laz", std::string(100'001, 'a')); }},
        {"another name", [](const fs::path& f) { fs::rename(f / "a.laz", f / "c.laz"); }},
        {"elsewhere", [](const fs::path& f) { fs::rename(f / "deeper" / "b.laz", f / "b.laz"); }},
        {"one more", [](const fs::path& f) { write_text(f / "c.laz", ""); }},
        {"one less", [](const fs::path& f) { fs::remove(f / "empty.laz"); }},
    };
    for (const Case& c : cases) {
        INFO(c.name);
        const TemporaryFolder folder;
        make_survey(folder.path() / "survey");
        const std::string before = to_name(folder.path() / "survey");
        c.change(folder.path() / "survey");
        CHECK(to_name(folder.path() / "survey") != before);
    }
}

TEST_CASE("files of every kind of input count, outputs do not", "[raytracer][checkpoint][inputs]") {
    const TemporaryFolder folder;
    write_text(folder.path() / "world" / "cloud.ply", "ply");
    write_text(folder.path() / "world" / "map.sqlite", "map");
    // Outputs are recognised by canonical paths, however the folder is named.
    fs::create_directory_symlink(folder.path() / "world", folder.path() / "link");
    const fs::path input = folder.path() / GENERATE("world", "link");
    const auto name = [&] {
        return farm::name_inputs({input.string()}, {}, {},
                                 [&](const fs::path& file) {
                                     return file == fs::canonical(folder.path()) / "world" /
                                                        "frames" / "0.png";
                                 })
            .front();
    };
    const std::string before = name();
    CHECK_THAT(before, contains(": 2 files, 6 bytes, "));
    write_text(folder.path() / "world" / "frames" / "0.png", "frame");
    CHECK(name() == before);
    write_text(folder.path() / "world" / "cloud.ply", "PLY");
    CHECK(name() != before);
}

TEST_CASE("all that shapes a picture is named, in order", "[raytracer][checkpoint][inputs]") {
    const TemporaryFolder folder;
    write_text(folder.path() / "photo.tif", "photo");
    const auto names = farm::name_inputs({"generated:7", "http://127.0.0.1:8080"},
                                         {folder.path() / "photo.tif"}, {});
    REQUIRE(names.size() == 4);
    CHECK(names[0] == "generated:7");
    CHECK(names[1] == "http://127.0.0.1:8080");
    CHECK_THAT(names[2], contains("orthophoto photo.tif: 1 file, 5 bytes, "));
    CHECK_THAT(names[3], contains("configuration: "));
    scene::Scene clay;
    clay.quality.materials = "clay";
    CHECK(farm::name_inputs({}, {}, clay) != farm::name_inputs({}, {}, {}));
    scene::Scene own;
    own.world.settings = (folder.path() / "own.toml").string();
    write_text(own.world.settings, "# 1");
    const auto before = farm::name_inputs({}, {}, own);
    CHECK(before == farm::name_inputs({}, {}, own));
    write_text(own.world.settings, "# 2");
    CHECK(before != farm::name_inputs({}, {}, own));
}
