#include "voxelserver/out/export/formats/formats.hpp"

#include <fstream>
#include <set>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"

using namespace terravox;
using namespace terravox::exports;
using test::contains;
using test::TemporaryFolder;

namespace fs = std::filesystem;

namespace {

void write_file(const fs::path& path) {
    std::ofstream(path) << "of an earlier conversion\n";
}

}  // namespace

TEST_CASE("a format is chosen by name or ending", "[voxelserver][export][format]") {
    CHECK(find_format_by("", "a.tvx").name == "archive");
    CHECK(find_format_by("", "A.VOX").name == "vox");
    CHECK(find_format_by("", "my world").name == "anvil");
    CHECK(find_format_by("ply", "a.tvx").name == "ply");
    CHECK_THROWS_WITH(find_format_by("", "a.obj"), contains(".obj") && contains("archive (.tvx)"));
    CHECK_THROWS_WITH(find_format_by("fbx", "a.tvx"), contains("--to fbx"));
}

TEST_CASE("each format is found by its own name and its own ending",
          "[voxelserver][export][format]") {
    std::set<std::string> names;
    std::set<std::string> extensions;
    for (const Format* const format : formats()) {
        const std::string name(format->name);
        INFO(name);
        CHECK(names.insert(name).second);
        CHECK(extensions.insert(std::string(format->extension)).second);
        CHECK(&find_format_by(name, "anything") == format);
        CHECK(&find_format_by("", "place" + std::string(format->extension)) == format);
        CHECK_THAT(allowed_formats(), contains(name));
    }
}

TEST_CASE("a file that is there is replaced only with --overwrite, a folder never",
          "[voxelserver][export][format]") {
    const TemporaryFolder folder;
    WriteOptions overwrite;
    overwrite.overwrite = true;
    for (const Format* const format : formats()) {
        INFO(format->name);
        const fs::path out = folder.path() / ("place" + std::string(format->extension));
        CHECK_NOTHROW(format->check_target(out, {}));
        if (format->extension.empty()) {
            CHECK_THROWS_AS(format->check_target(out, overwrite), util::UsageError);
            continue;
        }
        write_file(out);
        CHECK_THROWS_WITH(format->check_target(out, {}), contains("is there already"));
        CHECK_NOTHROW(format->check_target(out, overwrite));
        fs::remove(out);
        fs::create_directory(out);
        CHECK_THROWS_WITH(format->check_target(out, overwrite), contains("is a folder"));
    }
}

TEST_CASE("parts of a divided volume count as that volume", "[voxelserver][export][format]") {
    const TemporaryFolder folder;
    const Format& vdb = find_format_by("vdb", folder.path());
    const fs::path out = folder.path() / "place.vdb";
    write_file(folder.path() / "other_0_0.vdb");
    CHECK_NOTHROW(vdb.check_target(out, {}));
    write_file(folder.path() / "place_0_4.vdb");
    CHECK_THROWS_WITH(vdb.check_target(out, {}), contains("place_0_4.vdb is there already"));
}
