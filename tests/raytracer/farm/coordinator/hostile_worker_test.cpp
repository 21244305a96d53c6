#include <atomic>
#include <functional>
#include <limits>

#include "raytracer/core/tiles/tile_codec.hpp"
#include "tests/catch.hpp"
#include "tests/raytracer/farm_bench.hpp"

using namespace terravox;
using namespace terravox::test;

namespace {

/// A worker that completes the handshake, and then handles each tile as the test defines.
class FakeWorker {
public:
    using OnTile = std::function<void(FakeWorker&, std::uint64_t picture, std::uint64_t id,
                                      const tiles::RenderTile&)>;
    FakeWorker(Job& job, std::unique_ptr<net::Link> link, OnTile on_tile)
        : m_job(job),
          m_link(std::move(link)),
          m_on_tile(std::move(on_tile)),
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

private:
    void run() {
        farm::OwnHello own;
        own.role = farm::WORKER;
        own.threads = 1;
        own.capacity = 4;
        own.name = "fake";
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
    std::thread m_thread;
};

const std::string& wanted() {
    static const std::string bytes = [] {
        Job job(farm_scene());
        return to_bytes(render_scene(job, 2));
    }();
    return bytes;
}

using Act = FakeWorker::OnTile;

/// Answers each tile with the right pixels, changed.
Act answers(std::function<void(tiles::TileResult&)> change) {
    return [change = std::move(change)](FakeWorker& w, auto picture, auto id,
                                        const tiles::RenderTile& t) {
        tiles::TileResult result = w.right(t);
        change(result);
        w.send_tile(picture, id, result);
    };
}

/// Answers each tile with a frame.
Act sends(std::function<void(farm::Frame&)> make) {
    return [make = std::move(make)](FakeWorker& w, auto, auto, const tiles::RenderTile&) {
        farm::Frame frame;
        make(frame);
        w.send(std::move(frame));
    };
}

void brighten(tiles::TileResult& result) {
    for (tiles::PixelSample& sample : result.samples)
        sample.colour.g += 0.001f;
}

struct OwnJob {
    Job job{farm_scene()};
};

/// A picture that a fake worker has a part in.
struct Bench : OwnJob, FarmBench {
    explicit Bench(int check_every = 200) : FarmBench(job, std::nullopt, check_every) {}

    /// @param is_enough when this process joins in; nothing: it does not
    void render_with(Act act, const std::function<bool()>& is_enough = nullptr) {
        output::Film film = empty_film(job);
        {
            const FakeWorker fake(job, plug(), std::move(act));
            std::atomic<bool> over{false};
            std::thread help([&] {
                while (is_enough && !is_enough() && !over)
                    std::this_thread::yield();
                if (is_enough)
                    add_threads(1);
            });
            CHECK(render(film).missing == 0);
            over = true;
            help.join();
        }
        CHECK(to_bytes(film) == wanted());
    }
};

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
        {"another tile", answers([](auto& r) { ++r.tile.x0, ++r.tile.x1; }), "another tile"},
        {"layers that nobody wants", answers([](auto& r) { r.layers.resize(r.samples.size()); }),
         "with layers"},
        {"measured values of a picture",
         answers([](auto& r) { r.bands.resize(2 * r.samples.size()); }), "2 bands; allowed: 0"},
        {"wrong pixels, well packed", answers(brighten), "wrong"},
        {"a hole where the coordinator has a box, with each tile", answers([](auto& r) {
             brighten(r);
             r.holes.insert({0, 0, 0, 0});
         }),
         "hole"},
        {"a hole beyond the world", answers([](auto& r) { r.holes.insert({0, 1000, 0, 1000}); }),
         "hole"},
        {"a frame of the coordinator's",
         sends([](farm::Frame& f) { f.mutable_task()->set_picture(1); }),
         "frame that no worker sends"},
        {"boxes of another world", sends([](farm::Frame& f) {
             f.mutable_need_box()->set_world_id(123);
             (void)f.mutable_need_box()->add_keys();
         }),
         "of another world"},
        {"boxes without end", sends([](farm::Frame& f) {
             for (int i = 0; i < 70'000; ++i)
                 (void)f.mutable_need_box()->add_keys();
         }),
         "more boxes than it may"},
        {"a pong from the future", sends([](farm::Frame& f) {
             f.mutable_pong()->set_stamp(std::numeric_limits<std::uint64_t>::max() / 2);
         }),
         "ping"},
    }));
    DYNAMIC_SECTION(c.name) {
        Bench bench;
        // It is alone until it is detected; then another worker joins.
        bench.render_with(c.act, [&] { return !bench.expelled().empty(); });
        REQUIRE(bench.expelled().size() == 1);
        CHECK_THAT(bench.expelled().front(), contains(c.says));
    }
}

TEST_CASE("a worker that lies now and then is found out, and all that it made is made again",
          "[raytracer][farm]") {
    Bench bench(4);
    int n = 0;
    const Act lies = answers([&](tiles::TileResult& r) {
        if (++n > 3)  // in each row: some of them are made again
            for (tiles::PixelSample& sample : r.samples)
                sample.colour.r = 7;
    });
    bench.render_with(lies, [&] { return !bench.expelled().empty(); });
    CHECK(bench.pool().counts().mended > 0);
}

TEST_CASE("duplicate answers, and answers without a lease, are counted and ignored",
          "[raytracer][farm]") {
    Bench bench;
    bench.render_with(
        [&](FakeWorker& w, std::uint64_t picture, std::uint64_t id, const tiles::RenderTile& t) {
            const tiles::TileResult result = w.right(t);
            for (int i = 0; i < 3; ++i)
                w.send_tile(picture, id, result);
            w.send_tile(picture + 1, id, result);
            w.send_tile(picture, id + 1'000'000, result);
        });
    CHECK(bench.expelled().empty());
}

TEST_CASE("a worker that answers pings and nothing else loses its tiles to others",
          "[raytracer][farm]") {
    Bench bench;
    std::atomic<int> got{0};
    bench.render_with([&](FakeWorker&, auto, auto, const tiles::RenderTile&) { ++got; },
                      [&] { return got > 0; });
    CHECK(bench.expelled().empty());
}

TEST_CASE("workers of one host that cannot render are left out, and the coordinator continues",
          "[raytracer][farm]") {
    Job job(farm_scene());
    FarmBench bench(job);
    output::Film film = empty_film(job);
    const Act failing = [](FakeWorker& w, std::uint64_t picture, std::uint64_t id,
                           const tiles::RenderTile&) {
        farm::Frame frame;
        frame.mutable_failed()->set_picture(picture);
        frame.mutable_failed()->set_id(id);
        frame.mutable_failed()->set_reason("out of memory");
        w.send(std::move(frame));
    };
    FakeWorker a(job, bench.plug(), failing), b(job, bench.plug(), failing),
        c(job, bench.plug(), failing);
    CHECK(bench.render(film).missing == 0);
    CHECK(to_bytes(film) == wanted());
    CHECK(bench.expelled().empty());
}
