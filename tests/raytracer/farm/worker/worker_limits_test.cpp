#include "raytracer/core/scene/scene_io.hpp"
#include "raytracer/farm/worker/picture_context.hpp"
#include "tests/catch.hpp"
#include "tests/raytracer/farm/worker/fake_coordinator.hpp"

using namespace terravox;
using namespace terravox::test;

namespace {

constexpr std::size_t kMiB = std::size_t{1} << 20;

tiles::RenderTile square(int edge_px, int at_px = 0) {
    return {0, 0, 0, at_px, edge_px, at_px + edge_px, 1, false, 0, 0};
}

}  // namespace

TEST_CASE("a lease whose pixels no frame can hold is refused before it is traced",
          "[raytracer][farm][worker]") {
    struct Case {
        const char* name;
        int edge_px;
        bool layers, refused;
    };
    for (const Case& c :
         {Case{"4096 x 4096", 4096, false, true}, Case{"1200 x 1200", 1200, false, true},
          Case{"512 x 512 with layers", 512, true, true}, Case{"512 x 512", 512, false, false},
          Case{"256 x 256 with layers", 256, true, false}}) {
        INFO(c.name);
        FakeCoordinator coordinator(1, 64 * kMiB);
        coordinator.begin(make_spec(c.layers));
        coordinator.lease(square(c.edge_px), 77);
        // A tile that is traced requests boxes.
        const auto answer = coordinator.next(
            [](const farm::Frame& f) { return f.has_failed() || f.has_need_box(); });
        REQUIRE(answer);
        CHECK(answer->has_failed() == c.refused);
        if (!answer->has_failed())
            continue;
        CHECK(answer->failed().id() == 77);
        CHECK_THAT(answer->failed().reason(), contains("bytes of pixels; allowed: up to") &&
                                                  contains("make quality.tile smaller"));
    }
}

TEST_CASE("leases in progress take no more than the worker's memory, however many are sent at once",
          "[raytracer][farm][worker]") {
    struct Case {
        const char* name;
        std::size_t memory_bytes;
        unsigned begun;
    };
    // A lease of 512 x 512 takes three times 7 MiB.
    for (const Case& c :
         {Case{"less than one needs", 16 * kMiB, 1}, Case{"as three need", 64 * kMiB, 3}}) {
        INFO(c.name);
        FakeCoordinator coordinator(4, c.memory_bytes);
        coordinator.begin(make_spec(false));
        constexpr unsigned kLeases = 8;
        for (unsigned i = 0; i < kLeases; ++i)
            coordinator.lease(square(512, static_cast<int>(i)), 1 + i);
        REQUIRE(coordinator.next([](const farm::Frame& f) { return f.has_need_box(); }));
        const auto all = [](const farm::Frame& f) {
            return f.has_heartbeat() && f.heartbeat().begun() + f.heartbeat().waiting() == kLeases;
        };
        std::optional<farm::Frame> heartbeat;
        // As many as it will begin: two heartbeats later there are no more.
        for (int i = 0; i < 3; ++i)
            heartbeat = coordinator.next(all);
        REQUIRE(heartbeat);
        CHECK(heartbeat->heartbeat().begun() == c.begun);
    }
}

TEST_CASE("a coordinator's texts are limited in size, and must have been requested",
          "[raytracer][farm][worker]") {
    FakeCoordinator coordinator(1, 64 * kMiB);
    coordinator.tell("of a picture that has ended");
    const auto is_heartbeat = [](const farm::Frame& f) { return f.has_heartbeat(); };
    CHECK(coordinator.next(is_heartbeat));
    coordinator.tell(std::string(2 * kMiB, '#'));
    int heartbeats = 0;
    while (heartbeats < 4 && coordinator.next(is_heartbeat))
        ++heartbeats;
    CHECK(heartbeats < 4);  // the worker has ended the link
    CHECK(coordinator.hang_up() == farm::WorkerSession::End::kLost);
}

TEST_CASE("a coordinator's scene names no file and no limit of the worker",
          "[raytracer][farm][worker]") {
    const farm::PictureSpec good = make_spec(false);
    CHECK_NOTHROW(farm::unpack_scene(good.scene));
    struct Case {
        const char* name;
        const char* field;
        const char* text;
    };
    for (const Case& c : {Case{"memory", "world.memory_mib", "1048576"},
                          Case{"threads", "processing.threads", "1000"},
                          Case{"timeout", "processing.box_timeout_s", "86400"},
                          Case{"a view", "camera.look", "/etc/hostname"},
                          Case{"materials", "quality.materials", "/etc/hostname"},
                          Case{"a time zone", "sun.zone", "../../etc/hostname"},
                          Case{"settings", "world.settings", "/etc/hostname"},
                          Case{"classes", "world.classes", "/etc/hostname"}}) {
        INFO(c.name);
        scene::Scene scene = farm::unpack_scene(good.scene);
        scene::set_field(scene, c.field, c.text);
        CHECK_THROWS_WITH(farm::unpack_scene(scene::to_toml(scene)),
                          contains("names files or limits of this machine"));
    }
}
