#include <atomic>
#include <functional>
#include <limits>

#include "raytracer/tiles/tile_codec.hpp"
#include "tests/catch.hpp"
#include "tests/eventually.hpp"
#include "tests/raytracer/farm_bench.hpp"

using namespace terravox;
using namespace terravox::test;

namespace {

/// A worker that completes the handshake, and then handles each tile as the test defines.
class FakeWorker {
public:
    using OnTile = std::function<void(FakeWorker&, std::uint64_t picture, std::uint64_t id,
                                      const tiles::RenderTile&)>;
    FakeWorker(Job& job, std::unique_ptr<net::Link> link, OnTile on_tile, std::string name = "fake")
        : m_job(job),
          m_link(std::move(link)),
          m_on_tile(std::move(on_tile)),
          m_name(std::move(name)),
          m_thread([this] { run(); }) {}
    ~FakeWorker() {
        m_link->abort();
        m_thread.join();
    }
    void send(farm::Frame frame) { m_link->send(std::move(frame)); }
    void send_bytes(std::uint64_t picture, std::uint64_t id, const std::string& bytes) {
        farm::Frame frame;
        frame.mutable_done()->set_picture(picture);
        frame.mutable_done()->set_id(id);
        frame.mutable_done()->set_result(bytes);
        send(std::move(frame));
    }
    void send_tile(std::uint64_t picture, std::uint64_t id, const tiles::TileResult& result) {
        const auto bytes = tiles::encode_tile(result);
        send_bytes(picture, id,
                   std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
    }
    /// The tile as it ought to be.
    tiles::TileResult right(const tiles::RenderTile& tile) {
        processors::ThreadProcessor processor(m_job.view, m_job.blocks, 1);
        processor.submit(tile);
        return *processor.take();
    }
    std::string told;  ///< why it was refused; read it after the thread's end only

private:
    void run() {
        farm::OwnHello own;
        own.role = farm::WORKER;
        own.threads = 1;
        own.capacity = 4;
        own.name = m_name;
        try {
            (void)farm::meet(*m_link, farm::make_hello(own), {farm::COORDINATOR});
        } catch (const farm::HelloError&) {
            return;
        }
        while (auto frame = m_link->receive()) {
            if (frame->has_ping()) {
                farm::Frame pong;
                pong.mutable_pong()->set_stamp(frame->ping().stamp());
                send(std::move(pong));
            }
            if (frame->has_task())
                for (const farm::Tile& t : frame->task().tiles())
                    m_on_tile(*this, frame->task().picture(), t.id(), farm::from_frame(t));
        }
    }

    Job& m_job;
    std::unique_ptr<net::Link> m_link;
    OnTile m_on_tile;
    const std::string m_name;
    std::thread m_thread;
};

const std::string& wanted() {
    static const std::string bytes = [] {
        Job job(farm_scene());
        return bytes_of(render_scene(job, 2));
    }();
    return bytes;
}

using Act = FakeWorker::OnTile;

tiles::TileResult changed(tiles::TileResult result,
                          const std::function<void(tiles::TileResult&)>& change) {
    change(result);
    return result;
}

}  // namespace

TEST_CASE("whatever a hostile worker sends, the picture is right, and the worker is expelled",
          "[raytracer][farm]") {
    struct Case {
        const char* name;
        Act act;
        const char* says;  ///< part of the reason for which it was expelled
    };
    const auto c = GENERATE(values<Case>({
        {"garbage",
         [](FakeWorker& w, auto picture, auto id, const tiles::RenderTile&) {
             w.send_bytes(picture, id, "garbage");
         },
         "tile"},
        {"nothing at all",
         [](FakeWorker& w, auto picture, auto id, const tiles::RenderTile&) {
             w.send_bytes(picture, id, "");
         },
         "tile"},
        {"a bit flipped on the way",
         [](FakeWorker& w, auto picture, auto id, const tiles::RenderTile& t) {
             auto bytes = tiles::encode_tile(w.right(t));
             bytes[bytes.size() / 2] ^= std::byte{4};
             w.send_bytes(picture, id,
                          std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
         },
         "tile"},
        {"another tile",
         [](FakeWorker& w, auto picture, auto id, const tiles::RenderTile& t) {
             tiles::RenderTile other = t;
             other.x0 += 1;
             other.x1 += 1;
             w.send_tile(picture, id,
                         changed(w.right(t), [&](tiles::TileResult& r) { r.tile = other; }));
         },
         "another tile"},
        {"layers that nobody wants",
         [](FakeWorker& w, auto picture, auto id, const tiles::RenderTile& t) {
             w.send_tile(picture, id, changed(w.right(t), [](tiles::TileResult& r) {
                             r.layers.resize(r.samples.size());
                         }));
         },
         "with layers"},
        {"measured values of a picture",
         [](FakeWorker& w, auto picture, auto id, const tiles::RenderTile& t) {
             w.send_tile(picture, id, changed(w.right(t), [](tiles::TileResult& r) {
                             r.bands.resize(2 * r.samples.size());
                         }));
         },
         "2 bands; allowed: 0"},
        {"wrong pixels, well packed",
         [](FakeWorker& w, auto picture, auto id, const tiles::RenderTile& t) {
             w.send_tile(picture, id, changed(w.right(t), [](tiles::TileResult& r) {
                             for (tiles::PixelSample& sample : r.samples)
                                 sample.colour.g += 0.001f;
                         }));
         },
         "wrong"},
        {"a hole where the coordinator has a box, with each tile",
         [](FakeWorker& w, auto picture, auto id, const tiles::RenderTile& t) {
             w.send_tile(picture, id, changed(w.right(t), [](tiles::TileResult& r) {
                             for (tiles::PixelSample& sample : r.samples)
                                 sample.colour.g += 0.001f;
                             r.holes.insert({0, 0, 0, 0});
                         }));
         },
         "hole"},
        {"a hole beyond the world",
         [](FakeWorker& w, auto picture, auto id, const tiles::RenderTile& t) {
             w.send_tile(picture, id, changed(w.right(t), [](tiles::TileResult& r) {
                             r.holes.insert({0, 1000, 0, 1000});
                         }));
         },
         "hole"},
        {"a frame of the coordinator's",
         [](FakeWorker& w, auto, auto, const tiles::RenderTile&) {
             farm::Frame frame;
             frame.mutable_task()->set_picture(1);
             w.send(std::move(frame));
         },
         "frame that no worker sends"},
        {"boxes of another world",
         [](FakeWorker& w, auto, auto, const tiles::RenderTile&) {
             farm::Frame frame;
             frame.mutable_need_box()->set_world_id(123);
             (void)frame.mutable_need_box()->add_keys();
             w.send(std::move(frame));
         },
         "of another world"},
        {"boxes without end",
         [](FakeWorker& w, auto, auto, const tiles::RenderTile&) {
             farm::Frame frame;
             for (int i = 0; i < 70'000; ++i)
                 (void)frame.mutable_need_box()->add_keys();
             w.send(std::move(frame));
         },
         "more boxes than it may"},
        {"a pong from the future",
         [](FakeWorker& w, auto, auto, const tiles::RenderTile&) {
             farm::Frame frame;
             frame.mutable_pong()->set_stamp(std::numeric_limits<std::uint64_t>::max() / 2);
             w.send(std::move(frame));
         },
         "ping"},
    }));
    DYNAMIC_SECTION(c.name) {
        const std::string& right = wanted();
        Job job(farm_scene());
        FarmBench bench(job);
        output::Film film = empty_film(job);
        {
            FakeWorker fake(job, bench.plug(), c.act);
            // It is alone until it is detected; then another worker joins.
            std::atomic<bool> over{false};
            std::thread help([&] {
                while (bench.expelled().empty() && !over)
                    std::this_thread::yield();
                bench.add_threads(1);
            });
            CHECK(bench.render(film).missing == 0);
            over = true;
            help.join();
        }
        CHECK(bytes_of(film) == right);
        REQUIRE(bench.expelled().size() == 1);
        CHECK_THAT(bench.expelled().front(), contains(c.says));
    }
}

TEST_CASE("a worker that lies now and then is found out, and all that it made is made again",
          "[raytracer][farm]") {
    Job job(farm_scene());
    FarmBench bench(job, std::nullopt, 4);
    output::Film film = empty_film(job);
    int n = 0;
    {
        FakeWorker fake(job, bench.plug(),
                        [&](FakeWorker& w, std::uint64_t picture, std::uint64_t id,
                            const tiles::RenderTile& t) {
                            const bool lie = ++n > 3;
                            w.send_tile(picture, id, changed(w.right(t), [&](tiles::TileResult& r) {
                                            if (lie)  // in each row: some of them are made again
                                                for (tiles::PixelSample& sample : r.samples)
                                                    sample.colour.r = 7;
                                        }));
                        });
        std::thread help([&] {
            while (bench.expelled().empty())
                std::this_thread::yield();
            bench.add_threads(1);
        });
        CHECK(bench.render(film).missing == 0);
        help.join();
    }
    CHECK(bytes_of(film) == wanted());
    CHECK(bench.pool().counts().mended > 0);
}

TEST_CASE("duplicate answers, and answers without a lease, are counted and ignored",
          "[raytracer][farm]") {
    Job job(farm_scene());
    FarmBench bench(job);
    output::Film film = empty_film(job);
    {
        FakeWorker fake(job, bench.plug(),
                        [&](FakeWorker& w, std::uint64_t picture, std::uint64_t id,
                            const tiles::RenderTile& t) {
                            const tiles::TileResult result = w.right(t);
                            for (int i = 0; i < 3; ++i)
                                w.send_tile(picture, id, result);
                            w.send_tile(picture + 1, id, result);
                            w.send_tile(picture, id + 1'000'000, result);
                        });
        CHECK(bench.render(film).missing == 0);
    }
    CHECK(bytes_of(film) == wanted());
    CHECK(bench.expelled().empty());
}

TEST_CASE("a worker that answers pings and nothing else loses its tiles to others",
          "[raytracer][farm]") {
    Job job(farm_scene());
    FarmBench bench(job);
    output::Film film = empty_film(job);
    std::atomic<int> got{0};
    {
        FakeWorker fake(
            job, bench.plug(),
            [&](FakeWorker&, std::uint64_t, std::uint64_t, const tiles::RenderTile&) { ++got; });
        std::thread help([&] {
            while (got == 0)
                std::this_thread::yield();
            bench.add_worker();
        });
        CHECK(bench.render(film).missing == 0);
        help.join();
    }
    CHECK(bytes_of(film) == wanted());
    CHECK(bench.expelled().empty());
}

namespace {

void fail(FakeWorker& w, std::uint64_t picture, std::uint64_t id) {
    farm::Frame frame;
    frame.mutable_failed()->set_picture(picture);
    frame.mutable_failed()->set_id(id);
    frame.mutable_failed()->set_reason("out of memory");
    w.send(std::move(frame));
}

}  // namespace

TEST_CASE("workers of one host that cannot render are left out, and the coordinator continues",
          "[raytracer][farm]") {
    Job job(farm_scene());
    FarmBench bench(job);
    output::Film film = empty_film(job);
    const auto failing = [](FakeWorker& w, std::uint64_t picture, std::uint64_t id,
                            const tiles::RenderTile&) { fail(w, picture, id); };
    FakeWorker a(job, bench.plug(), failing), b(job, bench.plug(), failing),
        c(job, bench.plug(), failing);
    CHECK(bench.render(film).missing == 0);
    CHECK(bytes_of(film) == wanted());
    CHECK(bench.expelled().empty());
}

TEST_CASE("a worker that joins and fails again and again ends no picture", "[raytracer][farm]") {
    Job job(farm_scene());
    FarmBench bench(job);
    // Another that never answers, so that the coordinator has no reason to do the work itself.
    FakeWorker silent(
        job, bench.plug(),
        [](FakeWorker&, std::uint64_t, std::uint64_t, const tiles::RenderTile&) {}, "silent");
    REQUIRE(eventually([&] { return bench.pool().status().size() == 1; }));
    constexpr std::uint64_t kTimes = 9;  // each has several tiles, and fails at one of them
    std::atomic<bool> over{false};
    std::thread again([&] {
        for (std::uint64_t i = 0; i < kTimes; ++i) {
            const auto failing = [](FakeWorker& w, std::uint64_t picture, std::uint64_t id,
                                    const tiles::RenderTile&) { fail(w, picture, id); };
            FakeWorker fake(job, bench.plug(), failing);
            while (bench.pool().counts().lost == i && !over)
                std::this_thread::yield();
        }
        bench.add_threads(1);
    });
    output::Film film = empty_film(job);
    CHECK_NOTHROW(bench.render(film));
    over = true;
    again.join();
    CHECK(bench.pool().counts().lost == kTimes);
    CHECK(bytes_of(film) == wanted());
}

TEST_CASE("a hole that the coordinator has as well hides no lie", "[raytracer][farm]") {
    const voxel::BoxKey hole{0, 0, 0, 0};
    const auto damaged = [&] {
        auto world = landscape();
        world->make_hole(hole);
        return world;
    };
    constexpr std::size_t kMemory_bytes = std::size_t{256} << 20;
    Job alone(farm_scene(), kMemory_bytes, damaged()), job(farm_scene(), kMemory_bytes, damaged());
    const std::string right = bytes_of(render_scene(alone, 2));
    FarmBench bench(job);
    output::Film film = empty_film(job);
    {
        FakeWorker fake(job, bench.plug(),
                        [&](FakeWorker& w, std::uint64_t picture, std::uint64_t id,
                            const tiles::RenderTile& t) {
                            tiles::TileResult result = w.right(t);
                            (void)job.blocks.get(hole);  // as if it had requested the box
                            for (tiles::PixelSample& sample : result.samples)
                                sample.colour.g += 0.001f;
                            result.holes.insert(hole);
                            w.send_tile(picture, id, result);
                        });
        std::atomic<bool> over{false};
        std::thread help([&] {
            while (bench.expelled().empty() && !over)
                std::this_thread::yield();
            bench.add_threads(1);
        });
        CHECK(bench.render(film).missing == 0);
        over = true;
        help.join();
    }
    CHECK(bytes_of(film) == right);
    REQUIRE(bench.expelled().size() == 1);
    CHECK_THAT(bench.expelled().front(), contains("wrong"));
}

TEST_CASE("of two workers that disagree the liar alone is expelled", "[raytracer][farm]") {
    Job job(farm_scene());
    FarmBench bench(job, std::nullopt, 0);  // nothing is checked but what they disagree about
    std::atomic<bool> honest_has_it{false};
    const auto answered = [&](const char* name) {
        for (const auto& member : bench.pool().status())
            if (member.name == name && member.bands > 0)
                return true;
        return false;
    };
    const tiles::RenderTile tile =
        tiles::plan_tiles(97, 53, 1, 16, core::TileOrder::kRows).front().front();
    bench.pool().submit(tile);
    FakeWorker liar(
        job, bench.plug(),
        [&](FakeWorker& w, std::uint64_t picture, std::uint64_t id, const tiles::RenderTile& t) {
            while (!honest_has_it)
                std::this_thread::yield();
            w.send_tile(picture, id, changed(w.right(t), [](tiles::TileResult& r) {
                            r.samples.front().colour.r = 7;
                        }));
        },
        "liar");
    while (bench.pool().status().empty() || bench.pool().status().front().leases == 0)
        (void)bench.pool().wait(std::chrono::milliseconds(1));
    FakeWorker honest(
        job, bench.plug(),
        [&](FakeWorker& w, std::uint64_t picture, std::uint64_t id, const tiles::RenderTile& t) {
            const tiles::TileResult result = w.right(t);
            if (!honest_has_it.exchange(true))
                while (!answered("liar"))
                    std::this_thread::yield();
            w.send_tile(picture, id, result);
        },
        "honest");
    // The second answer, and its effect.
    while (bench.pool().counts().checked < 2 || bench.expelled().empty())
        (void)bench.pool().wait(std::chrono::milliseconds(1));
    REQUIRE(bench.pool().status().front().name == "honest");
    const auto result = bench.pool().take();
    REQUIRE(result);
    CHECK(tiles::hash_of_pixels(*result) == tiles::hash_of_pixels(honest.right(tile)));
    CHECK(bench.expelled().size() == 1);
}
