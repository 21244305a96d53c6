#include "raytracer/core/walk/surroundings.hpp"

#include "tests/catch.hpp"
#include "tests/raytracer/core/walk/walk_fixture.hpp"

using namespace terravox;
using namespace terravox::test;

TEST_CASE("a hole beside a face is reported each time that it is met",
          "[raytracer][levels][hole]") {
    auto world = made_towers();
    world->level(0).make_hole({0, 0, 0, 0});
    const walk::LevelCut cut(world->info().bounds, 0);
    blocks::BlockManager blocks(*world, std::size_t{1} << 30);
    walk::BlockReader reader(blocks);
    walk::Surroundings surroundings(reader, cut);
    walk::Hit hit;
    hit.voxel = {-1, 40, 10};
    hit.face = core::Face::kTop;
    for (int time = 0; time < 3; ++time) {
        walk::Seen seen;
        while (!surroundings.around(hit, seen))
            (void)blocks.get(surroundings.missing());
        CHECK(seen.bits != 0);
        CHECK(surroundings.take_holes() == std::set<voxel::BoxKey>{{0, 0, 0, 0}});
    }
}
