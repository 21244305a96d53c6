#include "voxelserver/make/worlds/luanti/block_survey.hpp"

#include <algorithm>
#include <random>
#include <set>

#include "common/voxel/pyramid_world.hpp"
#include "tests/catch.hpp"

namespace terravox::luanti {
namespace {

TEST_CASE("an index lists the columns of boxes of every level that blocks lie in", "[luanti]") {
    const unsigned seed = 17;
    CAPTURE(seed);
    std::mt19937 random(seed);
    BlockIndex index;
    std::set<std::pair<int, int>> columns;
    for (int i = 0; i < 200; ++i) {
        const auto any = [&] { return static_cast<std::int32_t>(random() % 4096) - 2048; };
        const BlockPlace place{any(), any(), any()};
        index.add(place);
        columns.insert({voxel::floor_div(place.x, 4), voxel::floor_div(place.z, 4)});
    }
    const int levels = voxel::levels_for(index.bounds());
    for (int level = 0; level < levels; ++level) {
        CAPTURE(level);
        const std::int32_t half = std::max(1, 512 >> level) + 1;
        int wrong = 0;
        for (std::int32_t bz = -half; bz < half; ++bz) {
            for (std::int32_t bx = -half; bx < half; ++bx)
                wrong += index.holds(level, bx, bz) != columns.contains({bx, bz}) ? 1 : 0;
        }
        CHECK(wrong == 0);
        std::set<std::pair<int, int>> coarser;
        for (const auto& [bx, bz] : columns)
            coarser.insert({voxel::floor_div(bx, 2), voxel::floor_div(bz, 2)});
        columns = coarser;
    }
}

TEST_CASE("a column's heights hold all of its blocks and no more", "[luanti]") {
    BlockIndex index;
    index.add({-5, 7, 0});
    index.add({-8, -3, 3});
    index.add({0, 100, 0});
    CHECK(index.heights(-2, 0).begin == -3);
    CHECK(index.heights(-2, 0).end == 8);
    CHECK(index.heights(0, 0).begin == 100);
    CHECK(index.heights(0, 0).end == 101);
    const BlockIndex::Heights outside = index.heights(5000, -5000);
    CHECK(outside.begin == outside.end);
}

}  // namespace
}  // namespace terravox::luanti
