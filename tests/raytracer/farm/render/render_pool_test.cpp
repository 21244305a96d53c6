#include "raytracer/farm/render/render_pool.hpp"

#include <algorithm>

#include "tests/catch.hpp"
#include "tests/eventually.hpp"
#include "tests/raytracer/farm_bench.hpp"

using namespace terravox;
using namespace terravox::test;
using namespace std::chrono_literals;

namespace {

constexpr const char* kToken = "token-of-this-test-4e97b1d02c6f8a35";

render::RenderPoolOptions changing(int threads, bool green) {
    render::RenderPoolOptions out;
    out.threads = threads;
    out.green = green;
    out.changes = true;
    out.farm.credentials.token = kToken;
    return out;
}

/// A daemon on a port of this machine.
class Daemon {
public:
    Daemon()
        : m_daemon([] {
              farm::WorkerDaemonOptions options;
              options.listen = sockets::Address{"127.0.0.1", 0};
              options.credentials.token = kToken;
              options.memory_bytes = std::size_t{64} << 20;
              options.name = "there";
              return options;
          }()),
          m_thread([this] { m_daemon.run(m_stop.get_token()); }) {}
    ~Daemon() {
        m_stop.request_stop();
        m_thread.join();
    }
    [[nodiscard]] sockets::Address address() const { return {"127.0.0.1", m_daemon.port()}; }

private:
    farm::WorkerDaemon m_daemon;
    std::stop_source m_stop;
    std::thread m_thread;
};

/// The picture, with something done after each so many tiles.
template <class Act>
std::string render_picture(Job& job, processors::TileProcessor& processor, const Act& act) {
    const auto [width, height] = job.view.scene.output.size_px;
    const auto tiles = tiles::plan_tiles(width, height, 1, 8, core::TileOrder::kRows).front();
    for (const tiles::RenderTile& t : tiles)
        processor.submit(t);
    output::Film film = empty_film(job);
    for (std::size_t done = 0; done < tiles.size(); ++done) {
        act(done);
        while (!processor.wait(50ms)) {
        }
        const auto result = processor.take();
        REQUIRE(result);
        film.add(*result);
    }
    return to_bytes(film);
}

bool has(const render::RenderPool& render_pool, std::string_view kind) {
    const auto participants = render_pool.participants();
    return std::any_of(
        participants.begin(), participants.end(),
        [&](const render::RenderPool::Participant& h) { return h.status.kind == kind; });
}

}  // namespace

TEST_CASE("a crew changes while a picture is under way, and no pixel does", "[raytracer][farm]") {
    Job job(farm_scene());
    const std::string wanted = to_bytes(render_scene(job, 2));
    Daemon daemon;
    render::RenderPool render_pool(changing(0, true), job.blocks, farm::BoxSource{});
    const auto processor = render_pool.begin(job.view);
    CHECK(has(render_pool, "green"));
    const std::string is = render_picture(job, *processor, [&](std::size_t done) {
        if (done == 5)
            render_pool.set_threads(2);
        if (done == 10)
            render_pool.set_green(false);
        if (done == 15)
            render_pool.dial(daemon.address());
        if (done == 30)
            render_pool.set_threads(1);
        if (done == 35) {
            render_pool.set_green(true);
            render_pool.set_threads(0);
            CHECK_FALSE(has(render_pool, "threads"));
            CHECK(has(render_pool, "green"));
        }
    });
    CHECK(is == wanted);
    CHECK(render_pool.dialled() == std::vector{daemon.address().text()});
}

TEST_CASE("a worker that was disconnected does not return until it is dialled again",
          "[raytracer][farm]") {
    Job job(farm_scene());
    Daemon daemon;
    render::RenderPool render_pool(changing(0, true), job.blocks, farm::BoxSource{});
    const auto processor = render_pool.begin(job.view);
    const auto wait_for = [&](bool there) {
        CHECK(test::eventually([&] { return has(render_pool, "socket") == there; }));
    };
    for (int i = 0; i < 2; ++i) {
        render_pool.dial(daemon.address());
        wait_for(true);
        render_pool.hang_up(daemon.address().text());
        wait_for(false);
        CHECK(render_pool.dialled().empty());
    }
    // Another that hangs up is called again and again. By its third call the first one would have
    // been called again, too.
    std::atomic<int> calls{0};
    const net::Listener restless({"127.0.0.1", 0}, changing(0, true).farm.credentials,
                                 [&](const std::unique_ptr<net::Link>&) { ++calls; });
    render_pool.dial({"127.0.0.1", restless.port()});
    CHECK(test::eventually([&] { return calls >= 3; }));
    CHECK_FALSE(has(render_pool, "socket"));
    render_pool.hang_up("127.0.0.1:1");  // was never there
}

TEST_CASE("the next picture of a pool begins when the last is released, finished or not",
          "[raytracer][farm]") {
    Job job(farm_scene());
    const std::string wanted = to_bytes(render_scene(job, 2));
    render::RenderPool render_pool(changing(1, true), job.blocks, farm::BoxSource{});
    for (int i = 0; i < 20; ++i) {
        auto processor = render_pool.begin(job.view);
        const auto passes = tiles::plan_tiles(97, 53, 1, 8, core::TileOrder::kRows);
        for (const tiles::RenderTile& t : passes.front())
            processor->submit(t);
        (void)processor->wait(std::chrono::milliseconds(i % 4));
    }
    CHECK(render_picture(job, *render_pool.begin(job.view), [](std::size_t) {}) == wanted);
}

TEST_CASE(
    "a worker cannot be called without a token, and a pool that does not change needs a member",
    "[raytracer][farm]") {
    Job job(farm_scene());
    render::RenderPoolOptions options = changing(1, false);
    options.farm.credentials = {};
    render::RenderPool render_pool(options, job.blocks, farm::BoxSource{});
    CHECK_THROWS_WITH(render_pool.dial({"127.0.0.1", 7878}), contains("no token"));
    options.changes = false;
    options.threads = 0;
    CHECK_THROWS_AS(render::RenderPool(options, job.blocks, farm::BoxSource{}), util::UsageError);
}
