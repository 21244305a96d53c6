#include <optional>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/voxelserver/data/store/fishnet.hpp"
#include "voxelserver/data/store/grabber_store.hpp"

using namespace terravox;
using namespace terravox::test;
using store::StoredState;
namespace fs = std::filesystem;

namespace {

/// By name; fails the test when there is none.
const store::StoredSquare& square(const store::GrabberStore& in, const std::string& name) {
    for (const auto& s : in.squares)
        if (s.name == name)
            return s;
    throw std::runtime_error("no square " + name);
}

}  // namespace

TEST_CASE("the schema that is read is the one that the grabber makes",
          "[voxelserver][store][grabber]") {
    CHECK(Fishnet::migrations().size() == static_cast<std::size_t>(store::kGrabberSchema));
}

TEST_CASE("a store that the grabber filled lists its squares", "[voxelserver][store][grabber]") {
    const TemporaryFolder folder;
    const fs::path& root = folder.path();
    write_content(root / "lidar/si-lss/462_101.laz", "12345");
    write_content(root / "lidar/si-lss/469_101.las", "12345");
    {
        Fishnet fishnet(root);
        fishnet.add("463_101", "missing");
        fishnet.add_verified("462_101", "lidar/si-lss/462_101.laz");
        fishnet.add("464_101", "wanted",
                    ", error_code, error_message, error_at, west, south, east, north, "
                    "grid_crs",
                    ", 'HTTP', 'x', '', 464000, 101000, 465000, 102000, 'EPSG:3857'");
        fishnet.add("465_101", "fetching");
        fishnet.add_failed("466_101", "503\nback later");
        fishnet.add_verified("467_101", "lidar/si-lss/467_101.laz");
        fishnet.add_verified("468_101", "lidar/si-lss/462_101.laz", 6);
        fishnet.add_verified("469_101", "lidar/si-lss/469_101.las", 5, "converted");
        fishnet.add("470_101", "known");
        fishnet.add("471_101", "fetched", ", file_path, file_bytes, file_sha256",
                    ", 'lidar/si-lss/471_101.zlas', 5, '00'");
    }
    const store::GrabberStore found = store::read_grabber_store(root);
    REQUIRE(found.squares.size() == 9);  // all but the one that is only known
    const auto& fetched = found.squares[0];
    CHECK(fetched.name == "462_101");
    CHECK(fetched.source == "si-lss");
    CHECK(fetched.state == StoredState::kFetched);
    CHECK(fetched.file == root / "lidar/si-lss/462_101.laz");
    CHECK(fetched.bytes == 5);
    CHECK(fetched.points == 123);
    REQUIRE(fetched.bounds);
    CHECK(fetched.bounds->min == std::array{1.0, 2.0, 3.5});
    CHECK(fetched.bounds->max == std::array{4.0, 5.0, 6.0});
    CHECK(fetched.crs == "EPSG:3794");
    CHECK(fetched.bounds_crs == "EPSG:3794");
    CHECK(fetched.class_table == "si-lss");
    CHECK(fetched.licence == "CC BY 4.0");
    CHECK(fetched.attribution == "ARSO \xc5\xbd");
    CHECK(square(found, "463_101").state == StoredState::kMissing);
    const auto& wanted = square(found, "464_101");
    CHECK(wanted.state == StoredState::kWanted);
    CHECK(wanted.error
              .empty());  // what went wrong before does not count while it is being fetched again
    REQUIRE(wanted.bounds);
    CHECK(wanted.bounds->min == std::array{464000.0, 101000.0, 0.0});
    CHECK(wanted.bounds->max == std::array{465000.0, 102000.0, 0.0});
    CHECK(wanted.bounds_crs == "EPSG:3857");
    CHECK(square(found, "465_101").state == StoredState::kWanted);
    CHECK_FALSE(square(found, "465_101").bounds);
    CHECK(square(found, "466_101").state == StoredState::kFailed);
    CHECK(square(found, "466_101").error == "503 back later");
    CHECK(square(found, "467_101").state == StoredState::kFailed);
    CHECK_THAT(square(found, "467_101").error, contains("467_101.laz is not there"));
    CHECK(square(found, "468_101").state == StoredState::kFailed);
    CHECK_THAT(square(found, "468_101").error, contains("5 bytes; it had 6"));
    CHECK(square(found, "469_101").state == StoredState::kFetched);
    CHECK(square(found, "471_101").state == StoredState::kWanted);
    REQUIRE(found.fetched().size() == 2);
    CHECK(found.fetched()[0] == &fetched);
    CHECK(found.fetched()[1]->file == root / "lidar/si-lss/469_101.las");
    CHECK(found.orthophotos.empty());
    CHECK(found.folder == root);
    CHECK(std::string(store::to_name(StoredState::kWanted)) == "wanted");
}

TEST_CASE("a square that is requested again keeps its old file until another takes its place",
          "[voxelserver][store][grabber]") {
    const TemporaryFolder folder;
    write_content(folder.path() / "lidar/si-lss/a.laz", "12345");
    Fishnet(folder.path()).add_verified("a", "lidar/si-lss/a.laz", 5, "fetching");
    CHECK(store::read_grabber_store(folder.path()).squares.at(0).state == StoredState::kFetched);
    write_content(folder.path() / "lidar/si-lss/a.laz", "123456");
    const auto replaced = store::read_grabber_store(folder.path()).squares.at(0);
    CHECK(replaced.state == StoredState::kWanted);
    CHECK(replaced.file.empty());
    CHECK(replaced.error.empty());
}

TEST_CASE("orthophotos are those that can be used and are there", "[voxelserver][store][grabber]") {
    const TemporaryFolder folder;
    {
        Fishnet fishnet(folder.path());
        int minute = 10;
        for (const char* name : {"whole", "cut", "gone", "begun"}) {
            const std::string verified =
                name == std::string("begun")
                    ? "NULL"
                    : "'2026-01-01T00:" + std::to_string(++minute) + ":00.000Z'";
            const std::string path = "ortho/si-dof/si-lss/" + std::string(name) + ".tif";
            if (name != std::string("gone"))
                write_content(folder.path() / path, name == std::string("cut") ? "1" : "123");
            fishnet.run(
                "INSERT INTO orthophotos (source, grid, name, state, urls, known_at, file_path, "
                "file_bytes, file_sha256, licence, attribution, verified_at) VALUES ('si-dof', "
                "'si-lss', '" +
                std::string(name) + "', 'fetched', '[]', '', '" + path +
                "', 3, '00', 'CC0', 'Agency P', " + verified + ")");
        }
    }
    const auto found = store::read_grabber_store(folder.path()).orthophotos;
    REQUIRE(found.size() == 1);
    CHECK(found[0].file == folder.path() / "ortho/si-dof/si-lss/whole.tif");
    CHECK(found[0].licence == "CC0");
    CHECK(found[0].attribution == "Agency P");
}

TEST_CASE(
    "a store is read while the grabber writes to it, and leaves nothing behind when it does not",
    "[voxelserver][store][grabber][all]") {
    const TemporaryFolder folder;
    std::optional<Fishnet> fishnet(folder.path());
    fishnet->add("a", "missing");
    REQUIRE(fs::file_size(folder.path() / "fishnet.gpkg-wal") > 0);
    CHECK(store::read_grabber_store(folder.path()).squares.size() ==
          1);  // it stands in the log only
    fishnet->run("BEGIN IMMEDIATE");
    fishnet->add("b", "missing");
    CHECK(store::read_grabber_store(folder.path()).squares.size() == 1);  // not committed
    fishnet->run("COMMIT");
    CHECK(store::read_grabber_store(folder.path()).squares.size() == 2);
    fishnet.reset();
    REQUIRE_FALSE(fs::exists(folder.path() / "fishnet.gpkg-wal"));
    CHECK(store::read_grabber_store(folder.path()).squares.size() == 2);
    CHECK(std::distance(fs::directory_iterator(folder.path()), fs::directory_iterator()) == 1);
    // Where no shared memory can be made, as on a disk without write access, the file itself is
    // enough, or it is an error.
    fs::create_directories(folder.path() / "fishnet.gpkg-shm");
    CHECK(store::read_grabber_store(folder.path()).squares.size() == 2);
    write_content(folder.path() / "fishnet.gpkg-wal", std::string(100, 'x'));
    CHECK_THROWS_AS(store::read_grabber_store(folder.path()), util::Error);
}

TEST_CASE("a store that is only just being filled is empty", "[voxelserver][store][grabber]") {
    const TemporaryFolder folder;
    write_content(folder.path() / ".grabber.lock", "1");
    CHECK(store::read_grabber_store(folder.path()).squares.empty());
    write_content(folder.path() / "fishnet.gpkg", "");
    CHECK(store::read_grabber_store(folder.path()).squares.empty());
    fs::remove(folder.path() / "fishnet.gpkg");
    const Fishnet made(folder.path());
    CHECK(store::read_grabber_store(folder.path()).squares.empty());
}
