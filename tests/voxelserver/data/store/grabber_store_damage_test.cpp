#include <functional>
#include <random>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/voxelserver/data/store/fishnet.hpp"
#include "voxelserver/data/store/grabber_store.hpp"

using namespace terravox;
using namespace terravox::test;
namespace fs = std::filesystem;

namespace {

/// @return what the store is refused with; one line that names the store
std::string refusal(const fs::path& folder) {
    try {
        static_cast<void>(store::read_grabber_store(folder));
    } catch (const util::Error& e) {
        const std::string message = e.what();
        CHECK_THAT(message, contains(folder.string()));
        CHECK(message.find('\n') == std::string::npos);
        CHECK(message.size() < 6000);
        return message;
    }
    return "it was read";
}

const std::string kUnchecked = "PRAGMA ignore_check_constraints = 1;";
const std::string kInsert = "INSERT INTO squares (source, grid, name, state, urls, known_at) ";

}  // namespace

TEST_CASE("what is no store is refused in one line that names it",
          "[voxelserver][store][grabber]") {
    struct Case {
        const char* name;
        std::function<void(Fishnet&)> harm;
        const char* says;
    };
    const auto sql = [](const std::string& text) { return [text](Fishnet& f) { f.run(text); }; };
    const auto verified = [](const std::string& path) {
        return [path](Fishnet& f) { f.add_verified("a", path); };
    };
    const auto named = [](const std::string& name) {
        return [name](Fishnet& f) { f.add(name, "missing"); };
    };
    const auto c = GENERATE_COPY(values<Case>({
        {"a newer version", sql("INSERT INTO terravox_schema VALUES (99, 'x', '')"),
         "version is 99"},
        {"an older version", sql("DELETE FROM terravox_schema WHERE version > 1"), "resume"},
        {"no version", sql("DELETE FROM terravox_schema"), "version is missing"},
        {"another GeoPackage", sql("DROP TABLE terravox_schema"), "no store"},
        {"another database", sql("PRAGMA application_id = 7"), "no GeoPackage"},
        {"no squares", sql("DROP TABLE squares"), "squares"},
        {"squares without a column", sql("DROP TABLE squares; CREATE TABLE squares (fid INTEGER)"),
         "no such column"},
        {"squares as a view without end",
         sql("DROP TABLE squares; CREATE VIEW squares AS WITH RECURSIVE n(i) AS (SELECT 1 UNION "
             "ALL SELECT i + 1 FROM n) SELECT i FROM n WHERE i < 0"),
         "squares"},
        {"squares as a virtual table",
         sql("DROP TABLE squares; CREATE VIRTUAL TABLE squares USING fts5(source)"), "squares"},
        {"an unknown state", sql(kUnchecked + kInsert + "VALUES ('s', 's', 'a', 'lost', '', '')"),
         "state = 'lost'"},
        {"verified without a file",
         sql(kUnchecked + kInsert + "VALUES ('s', 's', 'a', 'verified', '', '')"), "file_path"},
        {"a path out of the store", verified("lidar/../../etc/a.laz"), "file_path"},
        {"a path from the root", verified("/etc/a.laz"), "file_path"},
        {"a path to another folder", verified("ortho/si-lss/a.laz"), "file_path"},
        {"a path two folders down", verified("lidar/si-lss/x/a.laz"), "file_path"},
        {"a path with a backslash", verified("lidar/si-lss/x\\a.laz"), "file_path"},
        {"a path with an empty part", verified("lidar//a.laz"), "file_path"},
        {"a path to no point cloud", verified("lidar/si-lss/passwd"), "file_path"},
        {"an orthophoto out of the store",
         sql("INSERT INTO orthophotos (source, grid, name, state, urls, known_at, file_path, "
             "file_bytes, file_sha256, verified_at) "
             "VALUES ('s', 's', 'a', 'verified', '', '', 'ortho/../a.tif', 1, '', '')"),
         "file_path"},
        {"bytes below 0", [](Fishnet& f) { f.add_verified("a", "lidar/si-lss/a.laz", -5); },
         "file_bytes"},
        {"bytes in words",
         [](Fishnet& f) {
             f.add_verified("a", "lidar/si-lss/a.laz");
             f.run("UPDATE squares SET file_bytes = 'many'");
         },
         "file_bytes"},
        {"bounds that are no number",
         [](Fishnet& f) { f.add("a", "wanted", ", west, south, east, north", ", 1, 2, 9e999, 4"); },
         "west"},
        {"a square named up", named(".."), "name"},
        {"a square with a slash", named("a/b"), "name"},
        {"a square without a name", named(""), "name"},
        {"a name of two lines", named("a\nb"), "name"},
        {"a name without end", named(std::string(5000, 'a')), "name"},
        {"a name of bytes", sql(kInsert + "VALUES ('s', 's', x'00ff', 'missing', '', '')"),
         "name is no text"},
        {"a text of megabytes",
         [](Fishnet& f) {
             f.add("a", "missing");
             f.run("UPDATE squares SET licence = hex(zeroblob(2000000))");
         },
         "too big"},
        {"a square twice",
         [](Fishnet& f) {
             f.add("a", "missing");
             f.run(kInsert + "VALUES ('si-lss', 'other', 'a', 'missing', '', '')");
         },
         "twice"},
        {"more squares than any store",
         sql(kInsert +
             "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n WHERE i < 100002) "
             "SELECT 's', 's', 'n' || i, 'missing', '', '' FROM n"),
         "more than 100000"},
    }));
    DYNAMIC_SECTION(c.name) {
        const TemporaryFolder folder;
        {
            Fishnet fishnet(folder.path());
            c.harm(fishnet);
        }
        CHECK_THAT(refusal(folder.path()), contains(c.says));
    }
}

TEST_CASE("what is no database is refused", "[voxelserver][store][grabber]") {
    const TemporaryFolder folder;
    CHECK_THAT(refusal(folder.path()), contains("fishnet.gpkg"));
    CHECK_THAT(refusal(folder.path() / "none"), contains("no such folder"));
    write(folder.path() / "fishnet.gpkg",
          "no database, but long enough to be none" + std::string(200, '.'));
    CHECK_THAT(refusal(folder.path()), contains("not a database"));
    fs::remove(folder.path() / "fishnet.gpkg");
    fs::create_directories(folder.path() / "fishnet.gpkg");
    CHECK_THAT(refusal(folder.path()), contains("plain file"));
}

TEST_CASE("a database with wrong bytes is read or refused, and never ends the program",
          "[voxelserver][store][grabber][all]") {
    const TemporaryFolder folder;
    {
        Fishnet fishnet(folder.path());
        for (int i = 0; i < 200; ++i)
            fishnet.add_verified("s" + std::to_string(i), "lidar/si-lss/s.laz");
    }
    const fs::path file = folder.path() / "fishnet.gpkg";
    std::ifstream in(file, std::ios::binary);
    const std::string whole(std::istreambuf_iterator<char>(in), {});
    std::mt19937 random(20260621);
    int refused = 0;
    for (int round = 0; round < 400; ++round) {
        std::string bytes = whole;
        if (round % 4 == 0)
            bytes.resize(random() % bytes.size());
        else
            for (unsigned i = 0; i < 1 + random() % 40; ++i)
                bytes[round % 2 == 0 ? random() % bytes.size() : random() % 4096] =
                    static_cast<char>(random());
        write(file, bytes);
        INFO("round " << round);
        if (refusal(folder.path()) != "it was read")
            ++refused;
    }
    CHECK(refused > 100);
}
