#include "raytracer/farm/coordinator/worker_link.hpp"

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>

#include "tests/catch.hpp"
#include "tests/common/voxel/array_world.hpp"
#include "tests/raytracer/farm/link_pair.hpp"

using namespace terravox;

namespace {

/// A coordinator's link whose other end the test holds. The frames of the worker are sent before
/// run() reads them, on the same thread.
class LinkBench {
public:
    LinkBench() {
        auto [near, far] = net::link_pair();
        m_far = std::move(far);
        farm::WorkerLink::Reported reported;
        reported.accepts = [this] { ++m_accepted; };
        reported.pauses = [](bool) {};
        m_link = std::make_unique<farm::WorkerLink>(std::move(near), farm::Hello{}, m_supplier,
                                                    std::move(reported));
    }
    farm::WorkerLink& link() { return *m_link; }
    net::Link& worker() { return *m_far; }
    [[nodiscard]] int accepted() const { return m_accepted; }
    /// Sends a ping.
    /// @return its stamp, as the worker reads it
    std::uint64_t ping() {
        m_link->ping();
        const std::optional<farm::Frame> frame = m_far->receive();
        REQUIRE(frame);
        REQUIRE(frame->has_ping());
        return frame->ping().stamp();
    }
    void pong(std::uint64_t stamp) {
        farm::Frame frame;
        frame.mutable_pong()->set_stamp(stamp);
        CHECK(m_far->send(std::move(frame)));
    }
    /// Reads all that the worker has sent, and a goodbye.
    void run() {
        farm::Frame frame;
        frame.mutable_bye()->set_reason("the test has finished");
        CHECK(m_far->send(std::move(frame)));
        CHECK(m_link->run() == "it left");
        CHECK_FALSE(m_link->misbehaved());
    }

private:
    int m_accepted = 0;
    test::ArrayWorld m_world{{0, 0, 0}, {8, 8, 8}};
    blocks::BlockManager m_blocks{m_world, std::size_t{1} << 20};
    farm::BoxSupplier m_supplier{m_blocks, 7, std::size_t{1} << 20, 1};
    std::unique_ptr<net::Link> m_far;
    std::unique_ptr<farm::WorkerLink> m_link;
};

}  // namespace

TEST_CASE("a pong that echoes a ping gives the latency, on its own link only",
          "[raytracer][farm]") {
    LinkBench bench;
    const std::uint64_t stamp = bench.ping();
    bench.pong(stamp);
    bench.run();
    const double latency_s = bench.link().latency_s();
    CHECK(latency_s > 0);

    LinkBench other;
    other.pong(stamp);  // of another link
    other.run();
    CHECK(other.link().latency_s() == 0);
}

TEST_CASE("a worker's first frame after the hello tells whether it accepts the coordinator",
          "[raytracer][farm]") {
    using farm::WorkerAnswer;
    struct Case {
        const char* name;
        void (*fill)(farm::Frame&);
        WorkerAnswer answer;
        const char* why;
    };
    const auto c = GENERATE(values<Case>({
        {"a heartbeat", [](farm::Frame& f) { f.mutable_heartbeat()->set_paused(true); },
         WorkerAnswer::kAccepts, "it left"},
        {"a ping", [](farm::Frame& f) { f.mutable_ping()->set_stamp(1); }, WorkerAnswer::kAccepts,
         "it left"},
        {"busy",
         [](farm::Frame& f) {
             f.mutable_refusal()->set_reason("elsewhere");
             f.mutable_refusal()->set_busy(true);
         },
         WorkerAnswer::kBusy, "it refuses: elsewhere"},
        {"a refusal", [](farm::Frame& f) { f.mutable_refusal()->set_reason("never"); },
         WorkerAnswer::kRefuses, "it refuses: never"},
        {"a goodbye", [](farm::Frame& f) { f.mutable_bye(); }, WorkerAnswer::kNone, "it left"},
    }));
    DYNAMIC_SECTION(c.name) {
        LinkBench bench;
        farm::Frame first;
        c.fill(first);
        CHECK(bench.worker().send(std::move(first)));
        farm::Frame bye;
        bye.mutable_bye()->set_reason("the test has finished");
        CHECK(bench.worker().send(std::move(bye)));
        CHECK(bench.link().run() == c.why);
        CHECK(bench.link().answer() == c.answer);
        CHECK(bench.accepted() == (c.answer == WorkerAnswer::kAccepts ? 1 : 0));
        CHECK_FALSE(bench.link().misbehaved());
    }
}
