#include "voxelserver/worlds/remote/remote_world.hpp"

#include <algorithm>

#include "tests/catch.hpp"
#include "tests/voxelserver/http/fake_world.hpp"
#include "voxelserver/http/router.hpp"
#include "voxelserver/http/server.hpp"

using namespace terravox;

TEST_CASE("the ray tracer's client sees the served world as it is",
          "[voxelserver][http][raytracer]") {
    test::FakeWorld world;
    world.failing.insert({0, 1, -1, 0});
    util::StageTimes times;
    boxes::BoxCache boxes(world, times, {.ahead = false});
    http::Router router(http::Service{world, times, boxes});
    http::ServerOptions options;
    options.port = 0;
    const http::Server server(router, options);
    const auto remote = remote::open_remote_world(server.url(), times);

    CHECK(remote->info().title == world.info().title);
    CHECK(remote->info().bounds == world.info().bounds);
    CHECK(remote->info().voxel_m == world.info().voxel_m);
    CHECK(remote->info().levels == world.info().levels);

    for (int level = 0; level < world.info().levels; ++level) {
        const auto range = voxel::boxes_over(world.info().bounds, level);
        // One box beyond the world on every side, too.
        for (std::int32_t bx = range.min.bx - 1; bx <= range.max.bx; ++bx)
            for (std::int32_t bz = range.min.bz - 1; bz <= range.max.bz; ++bz) {
                CHECK(remote->column(level, bx, bz) == world.column(level, bx, bz));
                for (std::int32_t by = range.min.by - 1; by <= range.max.by; ++by) {
                    const voxel::BoxKey key{level, bx, by, bz};
                    INFO(voxel::to_string(key));
                    const bool fails = key.level == 0 ? world.failing.contains(key)
                                                      : key.bx == 0 && key.by == -1 && key.bz == 0;
                    if (fails) {
                        CHECK_THROWS_WITH(remote->box(key), test::contains("damaged"));
                        continue;
                    }
                    const bool outside = bx < range.min.bx || bx >= range.max.bx ||
                                         by < range.min.by || by >= range.max.by ||
                                         bz < range.min.bz || bz >= range.max.bz;
                    const auto expected = outside ? nullptr : world.box(key);
                    const auto got = remote->box(key);
                    REQUIRE((got == nullptr) == (expected == nullptr));
                    if (got)
                        CHECK(std::equal(got->blob().begin(), got->blob().end(),
                                         expected->blob().begin(), expected->blob().end()));
                }
            }
    }
}
