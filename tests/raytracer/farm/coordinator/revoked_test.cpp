// What becomes of a farm's links when a certificate is revoked while they are there.
#include <atomic>
#include <filesystem>

#include "raytracer/farm/net/certificates.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/eventually.hpp"
#include "tests/raytracer/farm/net/said.hpp"
#include "tests/raytracer/farm_bench.hpp"

using namespace terravox;
using namespace terravox::test;

namespace {

struct Certificates {
    TemporaryFolder folder;
    std::filesystem::path at = folder.path() / "certs";
    Certificates() { net::make_certs(at, {"coordinator", "worker", "observer"}, 30); }
    [[nodiscard]] net::Credentials of(const std::string& name) const {
        return {.token = {},
                .ca = at / "ca.pem",
                .certificate = at / (name + ".pem"),
                .key = at / (name + ".key")};
    }
    void revoke(const std::string& name) const { net::revoke_certs(at, {name}); }
};

const sockets::Address kAnywhere{.host = "127.0.0.1", .port = 0};

/// Takes tiles, answers pings, and does nothing else.
class IdleWorker {
public:
    IdleWorker(const sockets::Address& coordinator, const net::Credentials& credentials)
        : m_link(net::dial(coordinator, credentials, kHangs)), m_thread([this] { run(); }) {}
    ~IdleWorker() {
        m_link->abort();
        m_thread.join();
    }
    [[nodiscard]] bool has_ended() const noexcept { return m_ended; }

private:
    void run() {
        farm::OwnHello own;
        own.role = farm::WORKER;
        own.threads = 1;
        own.capacity = 4;
        own.name = "idle";
        (void)farm::meet(*m_link, farm::make_hello(own), {farm::COORDINATOR}, kHangs);
        while (auto frame = m_link->receive()) {
            if (!frame->has_ping())
                continue;
            farm::Frame pong;
            pong.mutable_pong()->set_stamp(frame->ping().stamp());
            (void)m_link->send(std::move(pong));
        }
        m_ended = true;
    }
    std::unique_ptr<net::Link> m_link;
    std::atomic<bool> m_ended{false};
    std::thread m_thread;
};

}  // namespace

TEST_CASE("a worker whose certificate is revoked is disconnected, and its leases are reassigned",
          "[raytracer][farm][tls]") {
    const Said said;
    const Certificates certificates;
    Job alone(farm_scene()), job(farm_scene());
    farm::FarmOptions options;
    options.listen = kAnywhere;
    options.credentials = certificates.of("coordinator");
    terravox::farm::Farm farm(options, job.blocks, {});
    processors::PoolSettings settings = pool_settings(job);
    settings.gone = [&](processors::ProcessorPool::MemberId id, const std::string& why,
                        bool expelled) { farm.gone(id, why, expelled); };
    processors::ProcessorPool pool(std::move(settings));
    farm.begin(pool, job.view.scene, job.view);
    const IdleWorker worker({.host = "127.0.0.1", .port = farm.port()}, certificates.of("worker"));
    REQUIRE(eventually([&] { return farm.workers() == 1 && !pool.status().empty(); }));
    const auto tiles = tiles::plan_tiles(97, 53, 1, 16, core::TileOrder::kRows).front();
    for (const tiles::RenderTile& tile : tiles)
        pool.submit(tile);
    (void)pool.wait(std::chrono::milliseconds(0));  // hands tiles out
    REQUIRE(pool.status().front().leases > 0);
    certificates.revoke("worker");
    CHECK(eventually([&] { return worker.has_ended(); }));
    CHECK(eventually([&] { return farm.workers() == 0 && pool.status().empty(); }));
    CHECK(said.hears("worker idle at 127.0.0.1:"));
    CHECK(said.hears("is disconnected: its certificate is revoked"));
    CHECK(pool.counts().given_back > 0);
    CHECK_THROWS_WITH(
        net::dial({.host = "127.0.0.1", .port = farm.port()}, certificates.of("worker"), kHangs),
        contains("its certificate is revoked"));
    pool.add({"here",
              "threads",
              1,
              true,
              false,
              std::make_shared<processors::ThreadProcessor>(job.view, job.blocks, 1),
              {}});
    output::Film film = empty_film(job);
    for (std::size_t i = 0; i < tiles.size(); ++i) {
        const auto result = pool.take();
        REQUIRE(result);
        film.add(*result);
    }
    CHECK(to_bytes(film) == to_bytes(render_scene(alone, 1)));
    farm.end();
}

TEST_CASE("a worker leaves a coordinator whose certificate is revoked, and does not return",
          "[raytracer][farm][tls]") {
    const Said said;
    const Certificates certificates;
    const net::Listener coordinator(
        kAnywhere, certificates.of("coordinator"), [](std::unique_ptr<net::Link> link) {
            (void)farm::meet(*link, farm::make_hello({}), {farm::WORKER}, kHangs);
            while (link->receive()) {
                farm::Frame ping;
                ping.mutable_ping()->set_stamp(1);
                (void)link->send(std::move(ping));
            }
        });
    farm::WorkerDaemonOptions options;
    options.join = {{.host = "127.0.0.1", .port = coordinator.port()}};
    options.credentials = certificates.of("worker");
    farm::WorkerDaemon daemon(options);
    REQUIRE(eventually([&] { return daemon.totals().now.size() == 1; }));
    certificates.revoke("coordinator");
    CHECK_THROWS_WITH(daemon.run({}), contains("no coordinator is left to join"));
    CHECK(daemon.totals().sessions == 1);
    CHECK(said.hears("is left: its certificate is revoked"));
}

TEST_CASE("an observer whose certificate is revoked gets no further status",
          "[raytracer][farm][tls]") {
    const Said said;
    const Certificates certificates;
    net::make_certs(certificates.at, {"looker"}, 30, "coordinator");
    Job job(farm_scene());
    farm::FarmOptions farm_options;
    farm::WorkerDaemonOptions daemon_options;
    farm_options.listen = daemon_options.listen = kAnywhere;
    farm_options.credentials = certificates.of("coordinator");
    daemon_options.credentials = certificates.of("worker");
    terravox::farm::Farm farm(farm_options, job.blocks, {});
    farm::WorkerDaemon daemon(daemon_options);
    const bool asks_daemon = GENERATE(false, true);
    const std::uint16_t port = asks_daemon ? daemon.port() : farm.port();
    const auto link =
        net::dial({.host = "127.0.0.1", .port = port}, certificates.of("looker"), kHangs);
    farm::OwnHello own;
    own.role = farm::OBSERVER;
    (void)farm::meet(*link, farm::make_hello(own), {farm::COORDINATOR, farm::WORKER}, kHangs);
    const auto answer = [&] {
        farm::Frame question;
        question.mutable_status_request();
        (void)link->send(std::move(question));
        return link->receive();
    };
    auto frame = answer();
    REQUIRE(frame);
    CHECK(frame->has_status());
    certificates.revoke("looker");
    frame = answer();
    CHECK((!frame || frame->has_refusal()));
}
