#include "raytracer/farm/coordinator/farm.hpp"

#include <atomic>
#include <functional>
#include <random>
#include <set>
#include <stop_token>

#include "raytracer/core/shade/view.hpp"
#include "tests/catch.hpp"
#include "tests/raytracer/farm/net/said.hpp"
#include "tests/raytracer/farm/worker/fake_coordinator.hpp"
#include "tests/raytracer/farm_bench.hpp"

using namespace terravox;
using namespace terravox::test;

namespace {

std::string local_picture(bool layers) {
    Job job(farm_scene(layers));
    return to_bytes(render_scene(job, 2));
}

}  // namespace

TEST_CASE(
    "workers make the picture that threads make, with and without layers, alone and together with "
    "threads",
    "[raytracer][farm]") {
    for (const bool layers : {false, true}) {
        const std::string wanted = local_picture(layers);
        for (const auto& [workers, threads] : {std::pair{1, 0}, std::pair{3, 1}}) {
            INFO(workers << " workers, " << threads << " threads" << (layers ? ", layers" : ""));
            Job job(farm_scene(layers));
            FarmBench bench(job);
            for (int i = 0; i < workers; ++i)
                bench.add_worker(1 + i % 2);
            if (threads > 0)
                bench.add_threads(threads);
            output::Film film = empty_film(job);
            const render::RenderCounts counts = bench.render(film);
            CHECK(to_bytes(film) == wanted);
            CHECK(counts.missing == 0);
            CHECK(bench.expelled().empty());
            // A worker's first tile always is checked; with threads in the pool it may get none.
            if (threads == 0)
                CHECK(bench.pool().counts().checked >= 1);
        }
    }
}

TEST_CASE(
    "several pictures through the same links are right: the worker keeps world and boxes, not "
    "the "
    "view",
    "[raytracer][farm]") {
    Job job(farm_scene());
    FarmBench first(job);
    first.add_worker();
    output::Film film = empty_film(job);
    (void)first.render(film);
    CHECK(to_bytes(film) == local_picture(false));
    scene::Scene other = farm_scene();
    other.sun.altitude_deg = 55;
    other.camera.azimuth_deg = 20;
    Job wanted(other);
    const std::string right = to_bytes(render_scene(wanted, 1));
    const shade::View view = shade::make_view(other, job.blocks);
    first.farm().end();
    {
        processors::PoolSettings settings = pool_settings(job);
        settings.make_checker = [&] {
            return std::make_shared<processors::ThreadProcessor>(view, job.blocks, 1);
        };
        processors::ProcessorPool pool(std::move(settings));
        first.farm().begin(pool, other, view);
        output::Film again = empty_film(job);
        (void)render::render_film({view, pool, true, {}}, again);
        CHECK(to_bytes(again) == right);
        first.farm().end();
    }
}

TEST_CASE(
    "workers meet the coordinator's holes, are checked there as elsewhere, and forget what has "
    "come back",
    "[raytracer][farm]") {
    const voxel::BoxKey hole{0, 0, 0, 0};
    const auto damaged = [&] {
        auto world = landscape();
        world->make_hole(hole);
        return world;
    };
    constexpr std::size_t kMemory_bytes = std::size_t{256} << 20;
    Job alone(farm_scene(), kMemory_bytes, damaged()), job(farm_scene(), kMemory_bytes, damaged());
    FarmBench bench(job, std::nullopt, 1);  // each band is checked
    bench.add_worker();
    output::Film film = empty_film(job);
    const render::RenderCounts counts = bench.render(film);
    CHECK((to_bytes(film) == to_bytes(render_scene(alone, 2))));
    CHECK(counts.holes == std::set<voxel::BoxKey>{hole});
    CHECK(bench.pool().counts().checked >= 28);
    CHECK(bench.expelled().empty());
    bench.farm().end();
    job.world->mend_hole(hole);
    job.blocks.forget_holes();
    {
        std::atomic<bool> expelled{false};
        processors::PoolSettings settings = pool_settings(job);
        settings.check_every = 1;
        settings.gone = [&](processors::ProcessorPool::MemberId, const std::string&,
                            bool is_expelled) { expelled = expelled || is_expelled; };
        processors::ProcessorPool pool(std::move(settings));
        bench.farm().begin(pool, job.view.scene, job.view);
        output::Film whole = empty_film(job);
        CHECK(render::render_film({job.view, pool, true, {}}, whole).holes.empty());
        CHECK((to_bytes(whole) == local_picture(false)));
        CHECK_FALSE(expelled);
        bench.farm().end();
    }
}

TEST_CASE("workers that die, leave and join at any time change no pixel", "[raytracer][farm]") {
    static const std::string wanted = local_picture(false);
    const auto seed = GENERATE(range(1u, 6u));
    INFO("seed " << seed);
    std::mt19937 random(seed);
    const auto any = [&](int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); };
    Job job(farm_scene());
    FarmBench bench(job);
    for (int i = 0; i < 3; ++i)
        bench.add_worker();
    const auto tiles = tiles::plan_tiles(97, 53, 1, 16, core::TileOrder::kRows).front();
    for (const tiles::RenderTile& t : tiles)
        bench.pool().submit(t);
    output::Film film = empty_film(job);
    std::set<std::uint32_t> done;
    while (done.size() < tiles.size()) {
        // The killed workers may be removed only now.
        while (!bench.pool().wait(std::chrono::milliseconds(100)))
            if (bench.farm().workers() == 0)
                bench.add_worker();
        const auto result = bench.pool().take();
        REQUIRE(result);
        film.add(*result);
        CHECK(done.insert(result->tile.index).second);
        switch (any(6)) {
            case 0: bench.kill(static_cast<std::size_t>(any(3))); break;
            case 1: bench.add_worker(); break;
            case 2: bench.drain(static_cast<std::size_t>(any(3))); break;
            default: break;
        }
    }
    CHECK(to_bytes(film) == wanted);
    CHECK(bench.expelled().empty());
}

TEST_CASE("without workers the picture waits, and ends incomplete after the timeout",
          "[raytracer][farm]") {
    Job job(farm_scene());
    FarmBench bench(job, std::chrono::milliseconds(300));
    output::Film film = empty_film(job);
    const render::RenderCounts counts = bench.render(film);
    CHECK(counts.missing == 28);
    CHECK(counts.tiles == 0);
}

TEST_CASE("a worker that is busy is no worker of the farm, and is reported once",
          "[raytracer][farm]") {
    const Said said;
    Job job(farm_scene());
    FarmBench bench(job);
    farm::WorkerDaemonOptions full;
    full.name = "the busy one";
    full.sessions = 0;
    farm::WorkerDaemon daemon(full);
    for (int i = 0; i < 3; ++i) {
        auto [mine, theirs] = net::link_pair();
        std::thread working(
            [&, end = std::move(theirs)]() mutable { (void)daemon.serve(std::move(end), false); });
        const farm::LinkOutcome outcome = bench.farm().serve(std::move(mine), "");
        working.join();
        CHECK(outcome.kind == farm::LinkOutcome::Kind::kNotNow);
        CHECK(outcome.why == "it refuses: the busy one works for another coordinator");
    }
    CHECK(daemon.totals().busy == 3);
    CHECK(bench.farm().workers() == 0);
    CHECK(bench.pool().counts().lost == 0);
    const std::string log = said.all();
    CHECK_THAT(log, contains("the busy one works for another coordinator"));
    CHECK(log.find("the busy one") == log.rfind("the busy one"));
}

TEST_CASE("a worker that refuses for good is not dialled again, one that is silent is",
          "[raytracer][farm]") {
    Job job(farm_scene());
    FarmBench bench(job);
    struct Case {
        const char* name;
        std::function<void(net::Link&)> act;
        farm::LinkOutcome::Kind kind;
        const char* why;
    };
    for (const Case& c :
         {Case{"refuses", [](net::Link& link) { farm::refuse(link, "no coordinators here"); },
               farm::LinkOutcome::Kind::kNever, "it refuses: no coordinators here"},
          Case{"leaves", [](net::Link& link) { link.close(); }, farm::LinkOutcome::Kind::kNotNow,
               "the other end closed it"}}) {
        INFO(c.name);
        auto [mine, theirs] = net::link_pair();
        std::thread working([&, end = std::move(theirs)] {
            farm::OwnHello own;
            own.role = farm::WORKER;
            own.threads = 1;
            own.capacity = 1;
            (void)farm::meet(*end, farm::make_hello(own), {farm::COORDINATOR});
            c.act(*end);
            while (end->receive()) {
            }
        });
        const farm::LinkOutcome outcome = bench.farm().serve(std::move(mine), "");
        working.join();
        CHECK(outcome.kind == c.kind);
        CHECK(outcome.why == c.why);
        CHECK(bench.pool().counts().lost == 0);
    }
}

namespace {

/// Sends a request to a coordinator or a worker, as `terravox farm` does.
/// @return the reply
farm::Frame asked(net::Link& link, const farm::Frame& question) {
    farm::OwnHello own;
    own.role = farm::OBSERVER;
    (void)farm::meet(link, farm::make_hello(own), {farm::WORKER, farm::COORDINATOR});
    CHECK(link.send(question));
    auto frame = link.receive();
    REQUIRE(frame);
    return std::move(*frame);
}

farm::Frame pause_frame(bool on, const std::string& worker = {}) {
    farm::Frame out;
    out.mutable_pause()->set_on(on);
    out.mutable_pause()->set_worker(worker);
    return out;
}

}  // namespace

TEST_CASE("a worker that is paused gets no leases until it is resumed", "[raytracer][farm]") {
    Job job(farm_scene());
    FarmBench bench(job);
    bench.add_worker();
    while (bench.farm().status().empty() || bench.farm().status().front().member == 0)
        std::this_thread::yield();
    const auto tiles = tiles::plan_tiles(97, 53, 1, 16, core::TileOrder::kRows).front();
    const auto state = [&] { return std::string(bench.pool().status().front().state); };
    SECTION("by its coordinator") {
        CHECK(asked(*bench.plug(), pause_frame(true, "nobody")).refusal().reason() ==
              "no such worker: 'nobody'");
        CHECK(asked(*bench.plug(), pause_frame(true, "worker 0")).has_status());
        CHECK(state() == "paused");
        for (const tiles::RenderTile& t : tiles)
            bench.pool().submit(t);
        CHECK_FALSE(bench.pool().wait(std::chrono::milliseconds(100)));
        CHECK(asked(*bench.plug(), pause_frame(false)).has_status());
    }
    SECTION("by itself") {
        const auto ask_worker = [&](bool on) {
            auto [mine, theirs] = net::link_pair();
            std::thread serving([&, end = std::move(theirs)]() mutable {
                (void)bench.daemon(0).serve(std::move(end), false);
            });
            CHECK(asked(*mine, pause_frame(on)).has_status());
            mine->abort();
            serving.join();
        };
        ask_worker(true);
        while (state() != "paused")
            std::this_thread::yield();
        for (const tiles::RenderTile& t : tiles)
            bench.pool().submit(t);
        CHECK_FALSE(bench.pool().wait(std::chrono::milliseconds(100)));
        ask_worker(false);
    }
    for (std::size_t done = 0; done < tiles.size(); ++done)
        REQUIRE(bench.pool().take());
}

TEST_CASE("a worker in the middle of a tile goes on with no other than it should",
          "[raytracer][farm]") {
    // Its boxes never arrive: tiles in progress do not end by themselves.
    FakeCoordinator coordinator(1, std::size_t{64} << 20);
    const auto tile = tiles::plan_tiles(97, 53, 1, 16, core::TileOrder::kSpiral).front().front();
    coordinator.begin(make_spec(false));
    coordinator.lease(tile, 77);
    const auto has_begun = [](unsigned tiles) {
        return [tiles](const farm::Frame& f) {
            return f.has_heartbeat() && f.heartbeat().begun() == tiles;
        };
    };
    REQUIRE(coordinator.next([](const farm::Frame& f) { return f.has_need_box(); }));
    REQUIRE(coordinator.next(has_begun(1)));
    SECTION("tiles that are not needed any more are left in the middle") {
        coordinator.stop(77);
        CHECK(coordinator.next(has_begun(0)));
    }
    SECTION("tiles that come while the worker leaves are given back") {
        coordinator.drain();
        REQUIRE(coordinator.next([](const farm::Frame& f) { return f.has_drain(); }));
        coordinator.lease(tile, 78);
        CHECK(coordinator.settle([](const farm::Frame& f) {
            return f.drain().given_back_size() == 1 && f.drain().given_back(0) == 78;
        }));
    }
}

TEST_CASE("a requester of boxes with a slow link does not delay others, and gets its boxes later",
          "[raytracer][farm]") {
    Job job(farm_scene());
    farm::BoxSupplier supplier(job.blocks, 7, std::size_t{1} << 20, 1);
    std::atomic<std::uint64_t> queued{std::uint64_t{20} << 20};
    std::atomic<int> slow{0}, quick{0};
    farm::BoxRequest request;
    request.set_world_id(7);
    for (int i = 0; i < 5; ++i)
        farm::to_frame(voxel::BoxKey{0, i - 2, 0, 0}, *request.add_keys());
    CHECK(supplier.request(
        1, request, {[&](farm::Frame) { return ++slow > 0; }, [&] { return queued.load(); }}));
    CHECK(supplier.request(2, request, {[&](farm::Frame) { return ++quick > 0; }}));
    while (quick < 5)
        std::this_thread::yield();
    CHECK(slow == 0);
    queued = 0;
    while (slow < 5)
        std::this_thread::yield();
    supplier.forget(1);
    supplier.forget(2);
    CHECK(quick == 5);
}

TEST_CASE("a requester waits for as many boxes as are allowed, and no more", "[raytracer][farm]") {
    Job job(farm_scene());
    farm::BoxSupplier supplier(job.blocks, 7, std::size_t{1} << 20, 1);
    const auto request = [&](std::uint64_t requester, std::size_t boxes) {
        farm::BoxRequest some;
        some.set_world_id(7);
        for (std::size_t i = 0; i < boxes; ++i)
            farm::to_frame(voxel::BoxKey{}, *some.add_keys());
        constexpr std::uint64_t kSlow = std::uint64_t{20} << 20;
        return supplier.request(requester, some,
                                {[](farm::Frame) { return true; }, [] { return kSlow; }});
    };
    constexpr std::size_t kMost = farm::BoxSupplier::kMaxWaiting;
    CHECK_FALSE(request(1, kMost + 1));
    CHECK(request(2, kMost - 1));
    CHECK_FALSE(request(2, 2));
    CHECK(request(2, 1));
    CHECK_FALSE(request(2, 1));
    supplier.forget(1);
    supplier.forget(2);
}
