// Prepared squares and chunk indices that a crash, a disk or another program has changed.
#include <functional>
#include <random>

#include "common/util/error.hpp"
#include "common/util/files.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/voxelserver/data/store/fishnet.hpp"
#include "tests/voxelserver/data/store/squares.hpp"
#include "voxelserver/data/store/grabber_store.hpp"
#include "voxelserver/data/store/square_folder.hpp"

using namespace terravox;
using namespace terravox::test;
namespace fs = std::filesystem;

namespace {

constexpr std::size_t kVersionAt = 8;  // bytes from the start of the file: behind the magic

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

TEST_CASE("a prepared square that was cut short, or grew, is refused",
          "[voxelserver][store][damage]") {
    const TemporaryFolder folder;
    const auto file = folder.path() / "a.square";
    const SquarePtr square = made_square(3, 5000, 12);
    store::write_square(file, *square);
    const std::string good = read_content(file);
    for (std::size_t size = 0; size < good.size(); size += size < 1000 ? 1 : 997) {
        INFO("cut to " << size << " of " << good.size() << " bytes");
        write_bytes(file, good.substr(0, size));
        CHECK_THROWS_AS(store::map_square(file), util::Error);
    }
    write_bytes(file, good + "x");
    CHECK_THROWS_AS(store::map_square(file), util::Error);
    write_bytes(file, good.substr(0, good.size() - 1));
    CHECK_THROWS_AS(store::map_square(file), util::Error);
}

TEST_CASE("another version, another kind of file and no such file at all are distinguished",
          "[voxelserver][store][damage]") {
    const TemporaryFolder folder;
    const auto square = folder.path() / "a.square";
    const auto chunks = folder.path() / "a.chunks";
    store::write_square(square, *made_square(3, 500, 2));
    store::write_chunks(chunks, made_index(3, 4));
    CHECK_THROWS_WITH(store::map_square(chunks), contains("a.chunks: not a prepared square"));
    CHECK_THROWS_WITH(store::read_chunks(square), contains("a.square: not a prepared square"));
    for (const auto& file : {square, chunks}) {
        std::string newer = read_content(file);
        newer[kVersionAt] = static_cast<char>(store::kSquareFileVersion + 1);
        write_bytes(file, newer);
    }
    const std::string said = "version " + std::to_string(store::kSquareFileVersion + 1) +
                             "; allowed: " + std::to_string(store::kSquareFileVersion);
    CHECK_THROWS_WITH(store::map_square(square), contains(said));
    CHECK_THROWS_WITH(store::read_chunks(chunks), contains(said));
}

TEST_CASE("whatever bytes of a prepared square change, no wrong point is read",
          "[voxelserver][store][damage]") {
    const TemporaryFolder folder;
    const auto file = folder.path() / "a.square";
    const SquarePtr square = made_square(3, 400, 12);
    store::write_square(file, *square);
    const std::string good = read_content(file);
    std::mt19937 random(2026);
    int at_once = 0;
    int later = 0;
    for (int round = 0; round < 300; ++round) {
        std::string bad = good;
        for (unsigned n = 1 + random() % 3; n > 0; --n)
            bad[random() % bad.size()] ^= static_cast<char>(1U << (random() % 8));
        if (bad == good)
            continue;
        write_bytes(file, bad);
        INFO("round " << round);
        SquarePtr found;
        try {
            found = store::map_square(file);
        } catch (const util::Error&) {
            ++at_once;
            continue;
        }
        REQUIRE(found);
        int refused = 0;
        for (const auto& patch : square->patches()) {
            std::span<const store::VoxelPoint> points;
            try {
                points = found->points(patch.key);
            } catch (const util::Error&) {
                ++refused;
                continue;
            }
            REQUIRE(same_points(points, square->points(patch.key)));
        }
        CHECK(refused > 0);
        ++later;
        // Writing it anew must not make the damage look sound.
        CHECK_THROWS_AS(store::write_square(folder.path() / "copy.square", *found), util::Error);
        CHECK_FALSE(std::filesystem::exists(folder.path() / "copy.square"));
    }
    CHECK(at_once > 25);
    CHECK(later > 25);
}

TEST_CASE(
    "a prepared square that is cut short in place while it is mapped is refused where it is gone",
    "[voxelserver][store][damage]") {
    const TemporaryFolder folder;
    const auto file = folder.path() / "a.square";
    const SquarePtr square = made_square(5, 200'000, 20);
    store::write_square(file, *square);
    const SquarePtr mapped = store::map_square(file);
    REQUIRE(mapped);
    const auto size = std::filesystem::file_size(file);
    std::filesystem::resize_file(file, size / 2);
    const auto map = util::MappedFile::open(file);
    std::filesystem::resize_file(file, size / 4);
    if (util::readable(map->bytes())) {
        WARN(
            "not tested: this system does not report what a map has lost (Linux does from 5.14 "
            "on)");
        return;
    }
    CHECK(std::ranges::equal(mapped->patches(), square->patches(), {}, &store::PatchEntry::key,
                             &store::PatchEntry::key));
    int refused = 0;
    int same = 0;
    for (const auto& patch : square->patches()) {
        std::span<const store::VoxelPoint> points;
        try {
            points = mapped->points(patch.key);
        } catch (const util::Error& e) {
            CHECK_THAT(e.what(), contains("damaged on disk"));
            ++refused;
            continue;
        }
        REQUIRE(same_points(points, square->points(patch.key)));
        ++same;
    }
    CHECK(refused > 10);
    CHECK(same > 3);
}

TEST_CASE("whatever bytes of a chunk index change or are lost, it is refused",
          "[voxelserver][store][damage]") {
    const TemporaryFolder folder;
    const auto file = folder.path() / "a.chunks";
    store::write_chunks(file, made_index(3, 20));
    const std::string good = read_content(file);
    std::mt19937 random(77);
    for (int round = 0; round < 200; ++round) {
        std::string bad = good;
        // Half of the rounds hit the counts and sizes, the others anything.
        const std::size_t at = round % 2 == 0 ? random() % 48 : random() % bad.size();
        bad[at] ^= static_cast<char>(1 + random() % 255);
        write_bytes(file, bad);
        INFO("round " << round << ", byte " << at);
        CHECK_THROWS_AS(store::read_chunks(file), util::Error);
    }
    for (std::size_t size = 0; size < good.size(); ++size) {
        write_bytes(file, good.substr(0, size));
        INFO("cut to " << size << " of " << good.size() << " bytes");
        CHECK_THROWS_AS(store::read_chunks(file), util::Error);
    }
    write_bytes(file, good + std::string(8, '\0'));
    CHECK_THROWS_AS(store::read_chunks(file), util::Error);
}

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
    write_content(folder.path() / "fishnet.gpkg",
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
    const std::string whole = read_content(file);
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
        write_content(file, bytes);
        INFO("round " << round);
        if (refusal(folder.path()) != "it was read")
            ++refused;
    }
    CHECK(refused > 100);
}
