#include <fstream>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/voxelserver/make/voxelize/world/patchwork.hpp"

using namespace terravox;
using namespace terravox::test;
using voxelize::SquareState;
namespace fs = std::filesystem;

namespace {

voxel::BoxKey box_at(double east, double north) {
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
    CHECK_THROWS_AS(world.world().box(box_at(430, 30)), util::Error);
    REQUIRE(world.world().box(box_at(30, 30)));
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
    CHECK_THROWS_WITH(world.world().box(box_at(430, 30)), contains("has changed"));
    CHECK(world.world().box(box_at(30, 30)));
    CHECK(world.world().squares()[1].state == SquareState::kFailed);
    OpenWorld again(options);
    CHECK(again.world().box(box_at(430, 30)));
}
