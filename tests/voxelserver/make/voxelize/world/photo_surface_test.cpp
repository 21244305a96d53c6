// The surface that casts shadows on photographs: without gaps, whichever patches are asked for.
#include <algorithm>
#include <cmath>

#include "tests/catch.hpp"
#include "tests/voxelserver/make/voxelize/world/cloud.hpp"
#include "voxelserver/make/voxelize/columns/point_set.hpp"
#include "voxelserver/make/voxelize/points/settings.hpp"
#include "voxelserver/make/voxelize/steps/photo_lights.hpp"

using namespace terravox;
using namespace terravox::test;

namespace {

constexpr double kTower_m = 160;
constexpr int kGap = 20;  // columns

grid::PatchKey patch_at(double east, double north) {
    return {voxel_x(east) >> 6, voxel_z(north) >> 6};
}

/// Rough land of 400 x 400 m with more gaps than points, and a tower on it. East of the patch at
/// its middle there is nothing for kGap columns, and then a terrace.
class RoughLand {
public:
    RoughLand() : m_points(written(m_folder.path() / "land.laz"), m_settings, m_times) {}
    [[nodiscard]] voxelize::PointSet& points() { return m_points; }

private:
    static voxelize::LidarWorldOptions written(const std::filesystem::path& file) {
        std::mt19937 random(7);
        Cloud cloud;
        const std::int32_t border = (patch_at(200, 200).px + 1) * grid::kPatchSize;
        cloud.cover(0, 0, 400, 400, 1, 2, [&](double east, double) {
            const auto number = random();
            const int past = voxel_x(east) - border;
            if (number % 3 != 0 || (past >= 0 && past < kGap))
                return std::nan("");
            return (past < 0 ? 100 : 200) + static_cast<double>(number >> 8 & 7);
        });
        cloud.cover(300, 200, 306, 206, 0.5, 6, [](double, double) { return 100 + kTower_m; });
        cloud.write(file);
        return OpenWorld::with(file);
    }

    TemporaryFolder m_folder;
    util::StageTimes m_times;
    voxelize::Settings m_settings;
    voxelize::PointSet m_points;
};

grid::PatchRect grown(grid::PatchKey key, std::int32_t by) {
    return {{key.px - by, key.pz - by}, {key.px + 1 + by, key.pz + 1 + by}};
}

}  // namespace

TEST_CASE("a patch's surface is filled from all around it, whatever is asked for with it",
          "[voxelserver][voxelize][photo-light]") {
    RoughLand land;
    voxelize::PhotoSurface surface(land.points());
    const grid::PatchKey key = patch_at(200, 200);
    const sunlight::Surface alone = surface.around(grown(key, 0), 2);
    const sunlight::Surface together = surface.around(grown(key, 1), 1);
    REQUIRE(alone.size() == together.size());
    constexpr int kReach = voxelize::PhotoSurface::kFilledTogether;
    int filled = 0;
    for (int z = alone.margin - kReach; z < alone.height - alone.margin + kReach; ++z)
        for (int x = alone.margin - kReach; x < alone.width - alone.margin + kReach; ++x) {
            const std::size_t i = alone.index(x, z);
            REQUIRE(alone.top_m[i] == together.top_m[i]);
            REQUIRE(alone.kind[i] == together.kind[i]);
            // Means of whole metres, where there was a gap.
            filled += alone.top_m[i] != std::floor(alone.top_m[i]) ? 1 : 0;
        }
    CHECK(filled > 1000);
    // From the patch, and not from the terrace, which lies in the same patch as these cells.
    const int border = alone.width - alone.margin;
    for (int z = alone.margin; z < alone.height - alone.margin; ++z) {
        INFO(z);
        const auto top_at = [&](int past) { return alone.top_m[alone.index(border + past, z)]; };
        for (int past = 0; past < kReach; ++past) {
            CHECK(top_at(past) > 99);
            CHECK(top_at(past) < 110);
        }
        // A wide gap farther away casts no shadow, whatever stands next to it.
        for (int past = kReach; past < kGap - sunlight::kSmallGap; ++past)
            CHECK(top_at(past) < -1000);
    }
}

TEST_CASE("a surface is as large as was asked for, and has what casts a shadow from another patch",
          "[voxelserver][voxelize][photo-light]") {
    RoughLand land;
    voxelize::PhotoSurface surface(land.points());
    const grid::PatchKey corner = patch_at(0, 400);
    const grid::PatchRect asked{{corner.px - 3, corner.pz - 2}, {corner.px + 1, corner.pz + 1}};
    const sunlight::Surface beyond = surface.around(asked, 1);
    CHECK(beyond.width == 6 * grid::kPatchSize);
    CHECK(beyond.height == 5 * grid::kPatchSize);
    CHECK(beyond.margin == grid::kPatchSize);
    CHECK(beyond.top_m.front() < -1000);
    CHECK(beyond.top_m[beyond.index(beyond.width - 70, beyond.height - 70)] > 99);
    const grid::PatchKey key = patch_at(200, 200);
    constexpr int kMargin = 2;
    const sunlight::Surface all = surface.around(grown(key, 0), kMargin);
    CHECK(std::ranges::none_of(all.top_m, [](float top) { return std::isnan(top); }));
    const int x = voxel_x(303) - (key.px - kMargin) * grid::kPatchSize;
    const int z = voxel_z(203) - (key.pz - kMargin) * grid::kPatchSize;
    CHECK(all.top_m[all.index(x, z)] == Approx(100 + kTower_m).margin(1));
}
