#include "raytracer/render/crew.hpp"

#include "tests/catch.hpp"
#include "tests/eventually.hpp"
#include "tests/raytracer/farm_bench.hpp"

using namespace terravox;
using namespace terravox::test;
using namespace std::chrono_literals;

namespace {

constexpr const char* kToken = "a token of the tests, of this one";

CrewOptions changing(int threads, bool green) {
    CrewOptions out;
    out.threads = threads, out.green = green, out.changes = true;
    out.farm.credentials.token = kToken;
    return out;
}

/// A daemon on a port of this machine.
class Daemon {
public:
    Daemon()
        : m_daemon([] {
              WorkerDaemonOptions options;
              options.listen = net::Address{"127.0.0.1", 0};
              options.credentials.token = kToken;
              options.memory_bytes = std::size_t{64} << 20;
              options.name = "there";
              return options;
          }()),
          m_thread([this] { m_daemon.run(); }) {}
    ~Daemon() {
        m_daemon.stop();
        m_thread.join();
    }
    [[nodiscard]] net::Address address() const { return {"127.0.0.1", m_daemon.port()}; }

private:
    WorkerDaemon m_daemon;
    std::thread m_thread;
};

/// The picture, with something done after each so many tiles.
template <class Act>
std::string picture_of(Job& job, TileProcessor& processor, const Act& act) {
    const auto [width, height] = job.view.scene.output.size_px;
    const auto tiles = plan_tiles(width, height, 1, 8, TileOrder::kRows).front();
    for (const RenderTile& t : tiles)
        processor.submit(t);
    Film film = empty_film(job);
    for (std::size_t done = 0; done < tiles.size(); ++done) {
        act(done);
        while (!processor.wait(50ms)) {
        }
        const auto result = processor.take();
        REQUIRE(result);
        film.add(*result);
    }
    return bytes_of(film);
}

bool has(const Crew& crew, std::string_view kind) {
    const auto hands = crew.hands();
    return std::any_of(hands.begin(), hands.end(),
                       [&](const Crew::Hand& h) { return h.status.kind == kind; });
}

}  // namespace

TEST_CASE("a crew changes while a picture is under way, and no pixel does", "[raytracer][farm]") {
    Job job(farm_scene());
    const std::string wanted = bytes_of(render(job, 2));
    Daemon daemon;
    Crew crew(changing(0, true), job.blocks, BoxSource{});
    const auto processor = crew.begin(job.view);
    CHECK(has(crew, "green"));
    const std::string is = picture_of(job, *processor, [&](std::size_t done) {
        if (done == 5)
            crew.set_threads(2);
        if (done == 10)
            crew.set_green(false);
        if (done == 15)
            crew.dial(daemon.address());
        if (done == 30)
            crew.set_threads(1);
        if (done == 35) {
            crew.set_green(true);
            crew.set_threads(0);
            CHECK_FALSE(has(crew, "threads"));
            CHECK(has(crew, "green"));
        }
    });
    CHECK(is == wanted);
    CHECK(crew.dialled() == std::vector{daemon.address().text()});
}

TEST_CASE("a worker that is sent away does not come back, until it is called again",
          "[raytracer][farm]") {
    Job job(farm_scene());
    Daemon daemon;
    Crew crew(changing(0, true), job.blocks, BoxSource{});
    const auto processor = crew.begin(job.view);
    const auto wait_for = [&](bool there) {
        CHECK(test::eventually([&] { return has(crew, "socket") == there; }));
    };
    for (int i = 0; i < 2; ++i) {
        crew.dial(daemon.address());
        wait_for(true);
        crew.hang_up(daemon.address().text());
        wait_for(false);
        CHECK(crew.dialled().empty());
    }
    // Another that hangs up is called again and again. By its third call the first one would have
    // been called again, too.
    std::atomic<int> calls{0};
    const net::Listener restless({"127.0.0.1", 0}, changing(0, true).farm.credentials,
                                 [&](const std::unique_ptr<net::Link>&) { ++calls; });
    crew.dial({"127.0.0.1", restless.port()});
    CHECK(test::eventually([&] { return calls >= 3; }));
    CHECK_FALSE(has(crew, "socket"));
    crew.hang_up("127.0.0.1:1");  // was never there
}

TEST_CASE("the next picture of a crew begins when the last is let go, finished or not",
          "[raytracer][farm]") {
    Job job(farm_scene());
    const std::string wanted = bytes_of(render(job, 2));
    Crew crew(changing(1, true), job.blocks, BoxSource{});
    for (int i = 0; i < 20; ++i) {
        auto processor = crew.begin(job.view);
        const auto passes = plan_tiles(97, 53, 1, 8, TileOrder::kRows);
        for (const RenderTile& t : passes.front())
            processor->submit(t);
        (void)processor->wait(std::chrono::milliseconds(i % 4));
    }
    CHECK(picture_of(job, *crew.begin(job.view), [](std::size_t) {}) == wanted);
}

TEST_CASE(
    "a worker cannot be called without a token, and a crew that does not change needs somebody",
    "[raytracer][farm]") {
    Job job(farm_scene());
    CrewOptions options = changing(1, false);
    options.farm.credentials = {};
    Crew crew(options, job.blocks, BoxSource{});
    CHECK_THROWS_WITH(crew.dial({"127.0.0.1", 7878}), contains("no token"));
    options.changes = false, options.threads = 0;
    CHECK_THROWS_AS(Crew(options, job.blocks, BoxSource{}), UsageError);
}
