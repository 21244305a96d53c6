// What a worker makes of answers to questions of an earlier picture.
#include "raytracer/core/tiles/tile_codec.hpp"
#include "tests/catch.hpp"
#include "tests/raytracer/farm/worker/fake_coordinator.hpp"

using namespace terravox;
using namespace terravox::test;

// The coordinator forgets its holes between pictures, and expels workers that have holes which it
// has not.
TEST_CASE(
    "a box that could not be loaded for an earlier picture is requested again, and is no hole of "
    "the "
    "next",
    "[raytracer][farm][worker]") {
    const tiles::RenderTile tile{0, 0, 0, 0, 97, 53, 1, false, 0, 0};
    const farm::PictureSpec spec = make_spec(false);
    FakeCoordinator coordinator(1, std::size_t{64} << 20);
    coordinator.begin(spec, 1);
    coordinator.lease(tile, 7);
    const auto asks = [](const farm::Frame& f) { return f.has_need_box(); };
    REQUIRE(coordinator.next(asks));
    // Another worker has computed the tile, and the answer is still on its way when the next
    // picture begins.
    coordinator.stop();
    coordinator.settle();
    // Boxes that the worker requests from here on may be for the next picture, which prefetches.
    const auto asked_before = coordinator.take_asked();
    coordinator.begin(spec, 2);
    coordinator.lease(tile, 8);
    const auto has_begun = [](const farm::Frame& f) {
        return f.has_heartbeat() && f.heartbeat().begun() == 1;
    };
    REQUIRE(coordinator.next(has_begun));
    for (const farm::BoxKey& key : asked_before)
        coordinator.reply(key, "the server is gone");
    while (const auto frame = coordinator.next([](const farm::Frame& f) {
        return f.has_need_box() || f.has_done() || f.has_failed();
    })) {
        for (const farm::BoxKey& key : coordinator.take_asked())
            coordinator.reply(key, "");
        if (!frame->has_need_box()) {
            REQUIRE(frame->has_done());
            CHECK(frame->done().picture() == 2);
            const auto bytes = std::as_bytes(std::span(frame->done().result()));
            CHECK(tiles::decode_tile(bytes, "the tile").holes.empty());
            return;
        }
    }
    FAIL("the worker has ended the link");
}
