// What a second world over the same cache folder does.
#include <chrono>

#include "tests/catch.hpp"
#include "tests/voxelserver/data/store/squares.hpp"
#include "tests/voxelserver/data/store/timed_world.hpp"

using namespace terravox;
using namespace terravox::test;
namespace fs = std::filesystem;

namespace {

/// Two files and a cache folder that lasts for one test.
struct Place {
    TemporaryFolder folder;
    fs::path west = folder.path() / "data" / "west.laz";
    fs::path east = folder.path() / "data" / "east.laz";
    fs::path cache = folder.path() / "cache";
    Place() {
        hills().write(west, kCrs, 6, [](const Cloud::Point& p) { return p.east < 80; });
        hills().write(east, kCrs, 6, [](const Cloud::Point& p) { return p.east >= 80; });
    }
    [[nodiscard]] voxelize::LidarWorldOptions options(bool cached = true) const {
        auto out = OpenWorld::with(folder.path() / "data");
        if (cached)
            out.cache_dir = cache;
        return out;
    }
    [[nodiscard]] std::vector<fs::path> squares() const {
        return files_ending(cache / "squares", ".square");
    }
    fs::path text(const char* name, const std::string& content) const {
        write_bytes(folder.path() / name, content);
        return folder.path() / name;
    }
};

}  // namespace

TEST_CASE("a second world over the same cache folder decodes nothing and makes the same boxes",
          "[voxelserver][store][restart]") {
    const Place place;
    const Checksums plain = TimedWorld(place.options(false)).boxes();
    REQUIRE(solid_boxes(plain) >= 9);
    {
        TimedWorld first(place.options());
        CHECK((first.boxes() == plain));
        CHECK(first.count("point load") > 0);
        CHECK(place.squares().size() == 2);
    }
    TimedWorld second(place.options());
    CHECK((second.boxes(3) == plain));
    CHECK(second.count("point load") == 0);
    CHECK(second->stats().outliers == TimedWorld(place.options(false))->stats().outliers);
    CHECK(place.squares().size() == 2);
}

// What else shapes them is in the name of a square: file_plan_test and square_name_test.
TEST_CASE("what shapes the points makes squares of another name, what does not uses them",
          "[voxelserver][store][restart]") {
    const Place place;
    TimedWorld(place.options()).boxes();
    REQUIRE(place.squares().size() == 2);
    const auto check = [&](std::size_t decoded, const auto& change) {
        auto cached = place.options();
        auto plain = place.options(false);
        change(cached);
        change(plain);
        TimedWorld world(cached);
        CHECK((world.boxes() == TimedWorld(plain).boxes()));
        CHECK((world.count("point load") > 0) == (decoded > 0));
        CHECK(place.squares().size() == 2 + decoded);
    };
    SECTION("another system") {
        check(2, [](auto& o) { o.crs = "EPSG:32631"; });
    }
    SECTION("withheld points kept") {
        const auto file = place.text("s.toml", "[points]\ndrop_withheld = false\n");
        check(2, [&](auto& o) { o.settings = file; });
    }
    SECTION("other steps") {
        const auto file = place.text("s.toml", "[steps]\nvegetation = false\n");
        check(0, [&](auto& o) { o.settings = file; });
    }
    SECTION("a file that was touched") {
        fs::last_write_time(place.west, fs::last_write_time(place.west) + std::chrono::seconds(5));
        check(1, [](auto&) {});
    }
}

TEST_CASE("voxel sizes that differ in the seventh digit share no squares",
          "[voxelserver][store][restart]") {
    const TemporaryFolder folder;
    Cloud field;
    field.cover(0, 0, 20, 20, 0.5, 2, [](double, double) { return 100.5; });
    field.write(folder.path() / "a.laz");
    auto options = OpenWorld::with(folder.path() / "a.laz");
    options.cache_dir = folder.path() / "cache";
    options.voxel_m = 0.3333333;
    TimedWorld(options).boxes();
    options.voxel_m = 0.3333334;
    TimedWorld cached(options);
    options.cache_dir.clear();
    CHECK((cached.boxes() == TimedWorld(options).boxes()));
    CHECK(files_ending(folder.path() / "cache" / "squares", ".square").size() == 2);
}
