#include "voxelserver/make/voxelize/columns/point_set.hpp"

#include <optional>

#include "tests/catch.hpp"
#include "tests/voxelserver/make/voxelize/world/cloud.hpp"

using namespace terravox;
using namespace terravox::test;
using namespace terravox::voxelize;

namespace {

/// Land of 400 x 400 m of which only the margin has points, in a file of its own.
class Margin {
public:
    explicit Margin(std::size_t memory_bytes = std::size_t{1} << 30) {
        Cloud cloud;
        cloud.cover(0, 0, 400, 400, 0.5, 2, [](double e, double n) {
            const bool outside = std::max(std::abs(e - 200), std::abs(n - 200)) > 190;
            return outside ? 100.5 : kNoHeight;
        });
        cloud.write(m_folder.path() / "margin.laz");
        auto options = OpenWorld::with(m_folder.path() / "margin.laz");
        options.memory_bytes = memory_bytes;
        m_points.emplace(options, m_settings, m_times);
    }
    [[nodiscard]] PointSet& points() { return *m_points; }
    [[nodiscard]] std::uint64_t decoded() const {
        for (const auto& stage : m_times.stages())
            if (stage.name == "point load")
                return stage.count;
        return 0;
    }

private:
    TemporaryFolder m_folder;
    util::StageTimes m_times;
    Settings m_settings;
    std::optional<PointSet> m_points;
};

grid::PatchKey patch_at(double east, double north) {
    return {voxel_x(east) >> 6, voxel_z(north) >> 6};
}

}  // namespace

TEST_CASE("a window decodes what it needs once, in however little memory",
          "[voxelserver][voxelize][points]") {
    Margin roomy;
    (void)roomy.points().window(patch_at(5, 200));
    const std::uint64_t whole = roomy.decoded();
    CHECK(whole > 0);
    Margin tight(1);
    (void)tight.points().window(patch_at(5, 200));
    CHECK(tight.decoded() <= 2 * whole);  // once to learn which part holds what
}

TEST_CASE("patches inside the bounds without a point are one and the same, and are covered",
          "[voxelserver][voxelize][points]") {
    Margin land;
    const auto empty = land.points().columns(patch_at(150, 150));
    CHECK_FALSE(empty->any);
    CHECK(land.points().columns(patch_at(250, 250)) == empty);
    for (const water::WaterCell& cell : empty->cells.cells)
        CHECK(cell.covered);
}

TEST_CASE("a patch outside the bounds is empty and not covered",
          "[voxelserver][voxelize][points]") {
    Margin land;
    const grid::PatchKey far_away = patch_at(900, 900);
    const auto outside = land.points().columns(far_away);
    REQUIRE(outside);
    CHECK_FALSE(outside->any);
    for (const water::WaterCell& cell : outside->cells.cells)
        CHECK_FALSE(cell.covered);
    CHECK(land.points().in_bounds(far_away).at(32, 32) == 0);
    CHECK(land.points().in_bounds(patch_at(200, 200)).at(32, 32) == 1);
}
