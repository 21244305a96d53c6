#include "voxelserver/make/voxelize/world/dependent_columns.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <random>
#include <set>
#include <string>

#include "tests/catch.hpp"
#include "tests/voxelserver/make/voxelize/world/patchwork.hpp"

using namespace terravox;
using namespace terravox::test;
using grid::ColumnRect;
using grid::PatchKey;
using voxel::InputExtent;

namespace {

bool reads(const InputExtent& reach, const ColumnRect& rect) {
    return rect.overlaps(
        {reach.min_bx * 64, reach.min_bz * 64, reach.max_bx * 64, reach.max_bz * 64});
}

/// The columns whose boxes say that they read a square, found by making all of them.
std::set<PatchKey> columns_reading(voxelize::LidarWorld& world, const ColumnRect& rect) {
    std::set<PatchKey> out;
    const voxel::BoxRange all = voxel::boxes_over(world.info().bounds, 0);
    for (std::int32_t bz = all.min.bz; bz < all.max.bz; ++bz)
        for (std::int32_t bx = all.min.bx; bx < all.max.bx; ++bx)
            if (reads(world.box_with_inputs({0, bx, all.min.by, bz}).reach, rect))
                out.insert({bx, bz});
    return out;
}

void check_all_squares(voxelize::LidarWorld& world) {
    const auto& squares = world.facts().squares;
    for (std::size_t i = 0; i < squares.size(); ++i) {
        INFO("square " << squares[i].name);
        const auto found = voxelize::columns_that_depend_on(world, {i}, 2);
        std::vector<PatchKey> missed;
        const auto expected = columns_reading(world, squares[i].bounds.grown(1));
        std::set_difference(expected.begin(), expected.end(), found.dependent.begin(),
                            found.dependent.end(), std::back_inserter(missed));
        CHECK(missed.size() == 0);
        // No more than the water that a column holds adds.
        for (const PatchKey& column : found.dependent)
            CHECK(reads(world.reach(column.px, column.pz), squares[i].bounds.grown(1)));
        for (const PatchKey& column : found.neighbours)
            CHECK(!expected.contains(column));
        CHECK((found.neighbours.empty() || found.neighbours.size() <= 8));
    }
}

/// Eight squares in a row, 128 m wide, with trees and no ground around the middle of all.
/// @param missing squares of the row that are not there
std::filesystem::path with_gap(const TemporaryFolder& folder, double gap_m,
                               const std::set<int>& missing = {}) {
    for (int i = 0; i < 8; ++i) {
        if (missing.contains(i))
            continue;
        Cloud cloud;
        std::mt19937 random(static_cast<unsigned>(i) + 1);
        for (int k = 0; k < 30'000; ++k) {
            const double east = i * 128 + 0.02 + static_cast<double>(random() % 127'900) / 1000;
            const double north = 0.02 + static_cast<double>(random() % 159'900) / 1000;
            const bool gap = std::abs(east - 512) < gap_m / 2;
            cloud.add(east, north, gap ? 320 : 300 + std::sin(east / 9), gap ? 5 : 2);
        }
        cloud.write(folder.path() / ("s" + std::to_string(i) + ".las"));
    }
    return folder.path();
}

}  // namespace

TEST_CASE("the columns that read a square are found without making all of them",
          "[voxelserver][voxelize][reach]") {
    SECTION("hills, a lake across squares, a hall") {
        const Patchwork patchwork;
        OpenWorld world(patchwork.options());
        check_all_squares(world.world());
    }
    for (const double gap_m : {100.0, 420.0, 1024.0})
        DYNAMIC_SECTION("no ground was seen for " << gap_m << " m") {
            const TemporaryFolder folder;
            OpenWorld world(OpenWorld::with(with_gap(folder, gap_m)));
            check_all_squares(world.world());
        }
    SECTION("squares are missing between one and those that find their ground in it") {
        const TemporaryFolder folder;
        OpenWorld world(OpenWorld::with(with_gap(folder, 700, {1, 2, 3})));
        check_all_squares(world.world());
    }
}
