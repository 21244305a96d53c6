#include "voxelserver/make/worlds/open/open_served_world.hpp"

#include <filesystem>
#include <fstream>

#include "common/util/error.hpp"
#include "common/voxel/world.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"
#include "voxelserver/make/worlds/open/open_world.hpp"

using namespace terravox;
using namespace terravox::worlds;
using terravox::test::contains;
using terravox::test::TemporaryFolder;
namespace fs = std::filesystem;

namespace {

/// Hills of 40 x 40 cells near the origin of EPSG:3794.
void write_heights(const fs::path& file, int lift) {
    std::ofstream out(file);
    out << "ncols 40\nnrows 40\nxllcorner 462000\nyllcorner 101000\ncellsize 5\n";
    for (int y = 0; y < 40; ++y) {
        for (int x = 0; x < 40; ++x)
            out << 300 + lift + (x * 7 + y * 3) % 20 << ' ';
        out << '\n';
    }
}

worlds::WorldOptions heights_in(const fs::path& file) {
    worlds::WorldOptions options;
    options.inputs = {file.string()};
    options.crs = "EPSG:3794";
    return options;
}

struct Served {
    explicit Served(const worlds::WorldOptions& options, const fs::path& maker)
        : world(open_served_world({options, {}, maker}, times, {})) {}
    util::StageTimes times;
    std::unique_ptr<ServedWorld> world;

    [[nodiscard]] voxel::Fingerprint fingerprint() const { return world->fingerprint({}); }
    /// A box in the middle of the world, of a level.
    [[nodiscard]] voxel::BoxKey middle(int level) const {
        const auto range = voxel::boxes_over(world->info().bounds, level);
        return {level, (range.min.bx + range.max.bx) / 2, range.min.by,
                (range.min.bz + range.max.bz) / 2};
    }
};

}  // namespace

TEST_CASE("a served world's boxes are those of the world, on all levels", "[voxelserver][worlds]") {
    const TemporaryFolder folder;
    const fs::path file = folder.path() / "hills.asc";
    write_heights(file, 0);
    const Served served(heights_in(file), file);
    util::StageTimes times;
    const auto direct = worlds::open_world(heights_in(file), times);
    CHECK(served.world->makes_all_levels());
    for (int level = 0; level < direct->info().levels; ++level) {
        const voxel::BoxKey key = served.middle(level);
        const auto expected = direct->box(key);
        const auto box = served.world->box_with_inputs(key).box;
        REQUIRE((expected != nullptr && box != nullptr));
        CHECK(box->checksum() == expected->checksum());
    }
}

TEST_CASE("a fingerprint names inputs, options and the program", "[voxelserver][worlds]") {
    const TemporaryFolder folder;
    const fs::path file = folder.path() / "hills.asc";
    const fs::path maker = folder.path() / "program";
    write_heights(file, 0);
    std::ofstream(maker) << "first";
    const voxel::Fingerprint before = Served(heights_in(file), maker).fingerprint();
    CHECK(Served(heights_in(file), maker).fingerprint() == before);
    SECTION("another option") {
        worlds::WorldOptions other = heights_in(file);
        other.base_m = 100;
        CHECK(Served(other, maker).fingerprint() != before);
    }
    SECTION("another content") {
        write_heights(file, 7);
        CHECK(Served(heights_in(file), maker).fingerprint() != before);
    }
    SECTION("another program") {
        std::ofstream(maker) << "second one";
        CHECK(Served(heights_in(file), maker).fingerprint() != before);
    }
    SECTION("another seed of noise") {
        worlds::WorldOptions one;
        one.inputs = {"generated:1"};
        worlds::WorldOptions two;
        two.inputs = {"generated:2"};
        CHECK(Served(one, maker).fingerprint() != Served(two, maker).fingerprint());
    }
}

TEST_CASE("once a file has changed, no box is made any more", "[voxelserver][worlds]") {
    const TemporaryFolder folder;
    const fs::path file = folder.path() / "hills.asc";
    write_heights(file, 0);
    const Served served(heights_in(file), folder.path() / "hills.asc");
    const voxel::BoxKey key = served.middle(0);
    REQUIRE(served.world->box(key) != nullptr);
    CHECK(served.world->failure().empty());
    SECTION("changed") {
        write_heights(file, 7);
    }
    SECTION("gone") {
        fs::remove(file);
    }
    CHECK_THROWS_AS(served.world->box(key), voxel::ChangedError);
    CHECK_THAT(served.world->failure(), contains("has changed since the server started"));
    write_heights(file, 0);
    CHECK_THROWS_AS(served.world->box(key), voxel::ChangedError);  // for good
}

TEST_CASE("flags that do not suit are refused", "[voxelserver][worlds]") {
    worlds::WorldOptions options;
    options.inputs = {"generated:1"};
    util::StageTimes times;
    CHECK_THROWS_WITH(open_served_world({options, {"--dimension"}, {}}, times, {}),
                      contains("--dimension with a generated world"));
}

TEST_CASE("LiDAR data is not opened this way", "[voxelserver][worlds]") {
    const TemporaryFolder folder;
    std::ofstream(folder.path() / "a.laz") << "LASF";
    worlds::WorldOptions options;
    options.inputs = {(folder.path() / "a.laz").string()};
    util::StageTimes times;
    CHECK_THROWS_AS(open_served_world({options, {}, {}}, times, {}), util::UsageError);
}

TEST_CASE("a text next to rasters of heights is one of them only if it holds heights",
          "[voxelserver][worlds]") {
    const TemporaryFolder folder;
    write_heights(folder.path() / "hills.txt", 0);
    std::ofstream(folder.path() / "README.txt") << "Heights of 2026, in metres.\n";
    std::ofstream(folder.path() / "LICENCE.TXT") << "CC BY 4.0\n";
    const fs::path maker = folder.path() / "program";
    std::ofstream(maker) << "first";
    CHECK_FALSE(Served(heights_in(folder.path()), maker).world->info().bounds.empty());
    // A file that should be a raster and is none is not left out silently.
    std::ofstream(folder.path() / "broken.tif") << "nothing";
    CHECK_THROWS_WITH(Served(heights_in(folder.path()), maker), contains("broken.tif"));
}
