#include <fstream>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/voxelserver/make/voxelize/world/cloud.hpp"
#include "tests/voxelserver/make/voxelize/world/patchwork.hpp"
#include "voxelserver/make/voxelize/world/store_options.hpp"
#include "voxelserver/make/voxelize/world/world_facts.hpp"

using namespace terravox;
using namespace terravox::test;
using store::StoredState;
using voxelize::SquareState;
namespace fs = std::filesystem;

namespace {

/// Flat ground at 100.5 m from `east` on for 40 m, a tower in its middle.
Cloud field(double east) {
    Cloud cloud;
    cloud.cover(east, 0, east + 40, 40, 0.5, 2, [](double, double) { return 100.5; });
    cloud.cover(east + 18, 18, east + 22, 22, 0.5, 15, [](double, double) { return 120.5; });
    return cloud;
}

/// The same places in another system.
Cloud in_crs(const std::string& crs, const Cloud& from) {
    const geo::Transform transform(geo::Crs::from_text(kCrs), geo::Crs::from_text(crs));
    Cloud out;
    for (const Cloud::Point& p : from.points()) {
        double x = kEast0 + p.east;
        double y = kNorth0 + p.north;
        transform.apply({&x, 1}, {&y, 1});
        out.add(x - kEast0, y - kNorth0, p.height, p.source_class);
    }
    return out;
}

store::StoredSquare square(const fs::path& file, const std::string& crs = kCrs) {
    store::StoredSquare out;
    out.name = file.stem().string();
    out.source = "here";
    out.state = StoredState::kFetched;
    out.file = file;
    out.crs = crs;
    return out;
}

voxelize::LidarWorldOptions options_from(const store::GrabberStore& store) {
    voxelize::LidarWorldOptions options;
    voxelize::take_from_store(store, options);
    return options;
}

voxel::BoxKey box_over(double east, double north) {
    return {0, voxel_x(east) >> 6, 1, voxel_z(north) >> 6};
}

/// Two squares far enough from each other that a box of one reads nothing of the other.
struct Two {
    Two() {
        for (const double east : {0.0, 400.0}) {
            Cloud cloud;
            cloud.cover(east, 0, east + 100, 100, 0.5, 2,
                        [](double e, double) { return 300 + e / 100; });
            cloud.write(file(east > 0 ? "b" : "a"));
        }
    }
    [[nodiscard]] fs::path file(const std::string& name) const {
        return folder.path() / (name + ".laz");
    }
    [[nodiscard]] voxelize::LidarWorldOptions options() const {
        return OpenWorld::with(folder.path());
    }
    TemporaryFolder folder;
    TemporaryFolder cache;
};

}  // namespace

TEST_CASE("a world names the licences and attributions of the store that it is made of",
          "[voxelserver][voxelize][store]") {
    const TemporaryFolder folder;
    field(0).write(folder.path() / "a.laz");
    field(40).write(folder.path() / "b.laz");
    store::GrabberStore store;
    store.squares = {square(folder.path() / "a.laz"), square(folder.path() / "b.laz"),
                     square("gone.laz"), square("wanted.laz")};
    store.squares[0].licence = "CC BY 4.0";
    store.squares[0].attribution = "Agency A";
    store.squares[1].licence = "CC BY 4.0";
    store.squares[1].attribution = "Agency B";
    for (std::size_t i : {2U, 3U}) {
        store.squares[i].state = i == 2 ? StoredState::kFailed : StoredState::kWanted;
        store.squares[i].licence = "ODbL";
        store.squares[i].attribution = "nothing of it is in the world";
    }
    const voxelize::LidarWorldOptions options = options_from(store);
    OpenWorld world(options);
    CHECK(world.info().licence == "CC BY 4.0");
    CHECK(world.info().attribution == "Agency A; Agency B");
    store.squares[1].attribution = "Agency C";
    CHECK(voxelize::world_name(options_from(store)) != voxelize::world_name(options));
}

TEST_CASE("photographs of a store add their terms, unless the user has others",
          "[voxelserver][voxelize][store]") {
    store::GrabberStore store;
    store.squares = {square("a.laz")};
    store.squares[0].licence = "CC BY 4.0";
    store.squares[0].attribution = "Agency A";
    store.orthophotos = {{"a.tif", "CC0", "Agency P"}, {"b.tif", "CC BY 4.0", "Agency A"}};
    const bool others = GENERATE(false, true);
    voxelize::LidarWorldOptions options;
    if (others)
        options.orthophotos = {"mine.tif"};
    voxelize::take_from_store(store, options);
    CHECK(options.orthophotos ==
          (others ? std::vector<fs::path>{"mine.tif"} : std::vector<fs::path>{"a.tif", "b.tif"}));
    CHECK(options.licence == (others ? "CC BY 4.0" : "CC BY 4.0; CC0"));
    CHECK(options.attribution == (others ? "Agency A" : "Agency A; Agency P"));
}

TEST_CASE("the user's CRS counts, then a square's own, and the recorded one where it has none",
          "[voxelserver][voxelize][store]") {
    const TemporaryFolder folder;
    constexpr const char* kOther = "EPSG:32631";
    struct Case {
        const char* name;
        std::string own;       ///< in the file; empty: none
        std::string recorded;  ///< in the store; empty: none
        std::string crs;       ///< of the points
    };
    const auto c = GENERATE(values<Case>({
        {"the file has another", kOther, kCrs, kOther},
        {"the file has none", "", kOther, kOther},
        {"nothing is recorded", kOther, "", kOther},
    }));
    DYNAMIC_SECTION(c.name) {
        // Next to a square in the first system, so that a wrong CRS would be a wrong place.
        field(0).write(folder.path() / "a.laz");
        in_crs(c.crs, field(40)).write(folder.path() / "b.laz", c.own);
        store::GrabberStore store;
        store.squares = {square(folder.path() / "a.laz"),
                         square(folder.path() / "b.laz", c.recorded)};
        OpenWorld world(options_from(store));
        CHECK(world.info().crs == kCrs);
        CHECK(world.top(voxel_x(20.5), voxel_z(20.5)) == 120);
        CHECK(world.top(voxel_x(60.5), voxel_z(20.5)) == 120);
        CHECK(world.top(voxel_x(50.5), voxel_z(5.5)) == 100);
    }
    field(0).write(folder.path() / "c.laz", kOther);
    store::GrabberStore store;
    store.squares = {square(folder.path() / "c.laz", "EPSG:32632")};
    voxelize::LidarWorldOptions of_user = options_from(store);
    of_user.crs = kCrs;
    CHECK(OpenWorld(of_user).info().crs == kCrs);
}

TEST_CASE("a store without squares, or with two class tables, is refused",
          "[voxelserver][voxelize][store]") {
    store::GrabberStore store;
    store.squares = {square("a.laz"), square("b.laz")};
    store.squares[0].class_table = "si-lss";
    store.squares[1].class_table = "nl-ahn";
    voxelize::LidarWorldOptions chosen;
    CHECK_THROWS_WITH(voxelize::take_from_store(store, chosen),
                      contains("nl-ahn") && contains("si-lss") && contains("--classes"));
    chosen = {};
    chosen.classes = "asprs";
    CHECK_NOTHROW(voxelize::take_from_store(store, chosen));
    for (store::StoredSquare& s : store.squares)
        s.state = StoredState::kWanted;
    CHECK_THROWS_WITH(options_from(store), contains("no square yet"));
}

TEST_CASE("a world of a store has the title of its source, or the name of the store",
          "[voxelserver][voxelize][store]") {
    store::GrabberStore store;
    store.folder = "places/bled/";
    store.squares = {square("TM_462_101.laz"), square("b.laz")};
    CHECK(options_from(store).title == "bled");  // no such source is known
    for (store::StoredSquare& s : store.squares)
        s.source = "si-lss";
    CHECK_THAT(options_from(store).title, contains("Slovenia, laser scanning"));
    store.squares[1].source = "si-clss";
    CHECK(options_from(store).title == "bled");
    store.squares[1].state = StoredState::kWanted;
    CHECK_THAT(options_from(store).title, contains("Slovenia, laser scanning"));
    voxelize::LidarWorldOptions given;
    given.title = "mine";
    voxelize::take_from_store(store, given);
    CHECK(given.title == "mine");
}

TEST_CASE("a world names its squares, and says which are prepared and why one has failed",
          "[voxelserver][voxelize][squares]") {
    const Two two;
    const auto size = fs::file_size(two.file("b"));
    OpenWorld world(two.options());
    auto squares = world.world().squares();
    REQUIRE(squares.size() == 2);
    CHECK(squares[0].name == "a");
    CHECK(squares[0].file == two.file("a"));
    CHECK(squares[0].points == 40'000);
    CHECK(squares[1].bytes == size);
    CHECK(squares[1].bounds.max_x - squares[1].bounds.min_x == 100);
    for (const auto& s : squares)
        CHECK(s.state == SquareState::kFetched);
    std::fstream(two.file("b"), std::ios::in | std::ios::out | std::ios::binary)
            .seekp(static_cast<std::streamoff>(size / 3))
        << std::string(size / 3, '\x5a');
    CHECK_THROWS_AS(world.world().box(box_over(430, 30)), util::Error);
    REQUIRE(world.world().box(box_over(30, 30)));
    squares = world.world().squares();
    CHECK(squares[0].state == SquareState::kPrepared);
    CHECK(squares[0].error.empty());
    CHECK(squares[1].state == SquareState::kFailed);
    CHECK_THAT(squares[1].error, contains("b.laz") && !contains("\n"));
}

TEST_CASE(
    "a file that is replaced after it was opened is refused: its points are not those of this "
    "world",
    "[voxelserver][voxelize][squares]") {
    const Two two;
    auto options = two.options();
    options.cache_dir = two.cache.path();
    OpenWorld world(options);
    Cloud other;
    other.cover(400, 0, 500, 100, 0.5, 2, [](double, double) { return 310; });
    other.write(two.file("b"));
    CHECK_THROWS_WITH(world.world().box(box_over(430, 30)), contains("has changed"));
    CHECK(world.world().box(box_over(30, 30)));
    CHECK(world.world().squares()[1].state == SquareState::kFailed);
    OpenWorld again(options);
    CHECK(again.world().box(box_over(430, 30)));
}
