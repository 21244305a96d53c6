#include <chrono>
#include <fstream>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"
#include "voxelserver/store/grabber_store.hpp"

using namespace terravox;
using namespace terravox::test;
using store::StoredState;
namespace fs = std::filesystem;

namespace {

void write(const fs::path& file, const std::string& text) {
    fs::create_directories(file.parent_path());
    std::ofstream(file, std::ios::binary) << text;
}

/// A record as the grabber writes it; `file` and `error` are JSON.
std::string record(const std::string& square, const std::string& state, const std::string& file = "null", const std::string& error = "null") {
    return R"({"source":"si-lss","square":")" + square + R"(","url":"https://example.org/a","state":")" + state +
           R"(","crs":"EPSG:3794","class_table":"si-lss","licence":"CC BY 4.0","attribution":"ARSO \u017d","file":)" + file +
           R"(,"warnings":["w"],"last_error":)" + error + "}";
}

std::string file_json(const std::string& path, int bytes = 5) {
    return R"({"path":")" + path + R"(","bytes":)" + std::to_string(bytes) +
           R"(,"sha256":"00","point_count":123,"las_version":"1.4","point_format":6,"bounds":{"min":[1,2,3.5],"max":[4,5,6]},"fetched_at":"2026-01-01T00:00:00Z"})";
}

std::string manifest(const std::string& records) { return R"({"version":1,"squares":[)" + records + "]}"; }

}  // namespace

TEST_CASE("a store that the grabber filled tells its squares", "[voxelserver][store][grabber]") {
    const TemporaryFolder folder;
    const fs::path& root = folder.path();
    write(root / "lidar/si-lss/462_101.laz", "12345");
    write(root / "lidar/si-lss/.465_101.part", "12");
    write(root / "lidar/si-lss/.465_101.part.json", "{}");
    write(root / "lidar/si-lss/.464_101.part", "12");
    const std::string error = R"({"code":"HTTP","message":"503\nback later","at":"2026-01-01T00:00:00Z"})";
    write(root / "manifest.json", manifest(record("463_101", "missing") + "," + record("462_101", "verified", file_json("lidar/si-lss/462_101.laz")) + "," +
                                           record("464_101", "failed", "null", error) + "," + record("466_101", "failed", "null", error) + "," +
                                           record("467_101", "verified", file_json("lidar/si-lss/467_101.laz")) + "," +
                                           record("468_101", "verified", file_json("lidar/si-lss/462_101.laz", 6))));
    const store::GrabberStore found = store::read_grabber_store(root);
    REQUIRE(found.squares.size() == 7);
    const auto& fetched = found.squares[0];
    CHECK(fetched.name == "462_101");
    CHECK(fetched.source == "si-lss");
    CHECK(fetched.state == StoredState::kFetched);
    CHECK(fetched.file == root / "lidar/si-lss/462_101.laz");
    CHECK(fetched.bytes == 5);
    CHECK(fetched.points == 123);
    REQUIRE(fetched.bounds);
    CHECK(fetched.bounds->min[2] == 3.5);
    CHECK(fetched.bounds->max[0] == 4);
    CHECK(fetched.crs == "EPSG:3794");
    CHECK(fetched.class_table == "si-lss");
    CHECK(fetched.licence == "CC BY 4.0");
    CHECK(fetched.attribution == "ARSO \xc5\xbd");
    CHECK(found.squares[1].state == StoredState::kMissing);
    CHECK(found.squares[2].state == StoredState::kWanted);  // failed, and being fetched again
    CHECK(found.squares[2].error.empty());
    CHECK(found.squares[3].name == "465_101");
    CHECK(found.squares[3].state == StoredState::kWanted);
    CHECK(found.squares[4].state == StoredState::kFailed);
    CHECK(found.squares[4].error == "503 back later");
    CHECK(found.squares[5].state == StoredState::kFailed);
    CHECK_THAT(found.squares[5].error, contains("467_101.laz"));
    CHECK(found.squares[6].state == StoredState::kFailed);
    CHECK_THAT(found.squares[6].error, contains("5 bytes"));
    CHECK(found.files() == std::vector<fs::path>{fetched.file});
    CHECK(found.orthophotos.empty());
    fs::create_directories(root / "orthophotos");
    CHECK(store::read_grabber_store(root).orthophotos == root / "orthophotos");
    CHECK(std::string(store::name_of(StoredState::kWanted)) == "wanted");
}

TEST_CASE("a store that is only just being filled is empty", "[voxelserver][store][grabber]") {
    const TemporaryFolder folder;
    write(folder.path() / ".grabber.lock", "1");
    CHECK(store::read_grabber_store(folder.path()).squares.empty());
    write(folder.path() / "lidar/adhoc/.a.part", "1");
    const auto found = store::read_grabber_store(folder.path());
    REQUIRE(found.squares.size() == 1);
    CHECK(found.squares[0].source == "adhoc");
    CHECK(found.squares[0].state == StoredState::kWanted);
}

TEST_CASE("what is no store is refused in one line that names it", "[voxelserver][store][grabber]") {
    struct Case { const char* name; std::string text; const char* says; };
    const std::string good = file_json("lidar/si-lss/a.laz");
    const auto c = GENERATE_COPY(values<Case>({
        {"no JSON", "{\"version\":1,\n\"squares\":[", "not JSON"},
        {"no text at all", "", "not JSON"},
        {"a list", "[]", "no object"},
        {"another version", R"({"version":2,"squares":[]})", "version"},
        {"a version in words", R"({"version":"1","squares":[]})", "version"},
        {"no squares", R"({"version":1})", "squares"},
        {"squares as an object", R"({"version":1,"squares":{}})", "squares"},
        {"a number for a square", manifest("7"), "squares.0"},
        {"nested deep", R"({"version":1,"squares":)" + std::string(2'000'000, '[') + "}", "nested"},
        {"nested deep in objects", [] {
             std::string text;
             for (int i = 0; i < 100'000; ++i) text += "{\"a\":";
             return text;
         }(), "nested"},
        {"more values than any store", "{\"version\":1,\"squares\":[1" + [] {
             std::string text;
             for (int i = 0; i < 4'100'000; ++i) text += ",1";
             return text;
         }() + "]}", "values"},
        {"a state nobody knows", manifest(record("a", "fetched")), "state"},
        {"verified without a file", manifest(record("a", "verified")), "file"},
        {"a path out of the store", manifest(record("a", "verified", file_json("lidar/../../etc/a.laz"))), "path"},
        {"a path from the root", manifest(record("a", "verified", file_json("/etc/a.laz"))), "path"},
        {"a path two folders down", manifest(record("a", "verified", file_json("lidar/si-lss/x/a.laz"))), "path"},
        {"a path with a backslash", manifest(record("a", "verified", file_json("lidar/si-lss/x\\\\a.laz"))), "path"},
        {"a path to no point cloud", manifest(record("a", "verified", file_json("lidar/si-lss/passwd"))), "path"},
        {"bytes below 0", manifest(record("a", "verified", file_json("lidar/si-lss/a.laz", -5))), "bytes"},
        {"a square named up", manifest(record("..", "missing")), "square"},
        {"a square with a slash", manifest(record("a/b", "missing")), "square"},
        {"a square without a name", manifest(record("", "missing")), "square"},
        {"a name of two lines", manifest(record("a\\nb", "missing")), "square"},
        {"a name without end", manifest(record(std::string(5000, 'a'), "missing")), "square"},
        {"a square twice", manifest(record("a", "missing") + "," + record("a", "missing")), "twice"},
        {"bytes that are no text", manifest(record("a\xff\xfe", "missing")), "not JSON"},
        {"an error in words", manifest(record("a", "failed", "null", "\"bad\"")), "last_error"},
    }));
    DYNAMIC_SECTION(c.name) {
        const TemporaryFolder folder;
        write(folder.path() / "manifest.json", c.text);
        try {
            static_cast<void>(store::read_grabber_store(folder.path()));
            FAIL("was read");
        } catch (const Error& e) {
            const std::string message = e.what();
            CHECK_THAT(message, contains(c.says));
            CHECK_THAT(message, contains(folder.path().string()));
            CHECK(message.find('\n') == std::string::npos);
            CHECK(message.size() < 6000);
        }
    }
    const TemporaryFolder folder;
    CHECK_THROWS_WITH(store::read_grabber_store(folder.path()), contains("manifest.json"));
    CHECK_THROWS_WITH(store::read_grabber_store(folder.path() / "none"), contains("no such folder"));
    fs::create_directories(folder.path() / "manifest.json");
    CHECK_THROWS_WITH(store::read_grabber_store(folder.path()), contains("plain file"));
}
