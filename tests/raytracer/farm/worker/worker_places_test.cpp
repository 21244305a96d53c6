// What a worker's places and counters become when a session or an observer fails.
#include <exception>
#include <memory>
#include <new>
#include <string>
#include <thread>
#include <tuple>
#include <utility>

#include "common/util/error.hpp"
#include "raytracer/farm/wire/frames.hpp"
#include "raytracer/farm/worker/worker_daemon.hpp"
#include "tests/catch.hpp"
#include "tests/raytracer/farm/link_pair.hpp"

using namespace terravox;

namespace {

using End = farm::WorkerSession::End;

/// A link on which every send fails after the first frame, which is the hello.
class FailingLink final : public net::Link {
public:
    /// @param failure  what send() throws
    FailingLink(std::unique_ptr<net::Link> link, std::exception_ptr failure)
        : m_link(std::move(link)), m_failure(std::move(failure)) {}
    bool send(farm::Frame frame) override {
        if (std::exchange(m_has_sent, true))
            std::rethrow_exception(m_failure);
        return m_link->send(std::move(frame));
    }
    std::optional<farm::Frame> receive() override { return m_link->receive(); }
    void close(std::chrono::milliseconds timeout) noexcept override { m_link->close(timeout); }
    void abort() noexcept override { m_link->abort(); }
    const std::string& peer() const noexcept override { return m_link->peer(); }
    std::string why_ended() const override { return m_link->why_ended(); }
    Traffic traffic() const noexcept override { return m_link->traffic(); }

private:
    std::unique_ptr<net::Link> m_link;
    const std::exception_ptr m_failure;
    bool m_has_sent = false;
};

/// The worker's end of a link whose other end has sent its hello already.
struct Met {
    explicit Met(farm::Role role) {
        std::tie(far, near) = net::link_pair();
        farm::OwnHello own;
        own.role = role;
        farm::Frame frame;
        *frame.mutable_hello() = farm::make_hello(own);
        CHECK(far->send(std::move(frame)));
    }
    std::unique_ptr<net::Link> near_that_fails(std::exception_ptr failure) {
        return std::make_unique<FailingLink>(std::move(near), std::move(failure));
    }
    std::unique_ptr<net::Link> far;
    std::unique_ptr<net::Link> near;
};

farm::Frame bye() {
    farm::Frame out;
    out.mutable_bye()->set_reason("the test has finished");
    return out;
}

/// Pauses a worker as an observer does, so that each later session begins with a heartbeat.
void pause(farm::WorkerDaemon& daemon) {
    Met observer(farm::OBSERVER);
    farm::Frame frame;
    frame.mutable_pause()->set_on(true);
    CHECK(observer.far->send(std::move(frame)));
    CHECK(observer.far->send(bye()));
    CHECK(daemon.serve(std::move(observer.near), false) == End::kBye);
}

}  // namespace

TEST_CASE("a session that fails before it runs gives its place back", "[raytracer][farm][worker]") {
    farm::WorkerDaemon daemon({});  // with one place
    pause(daemon);
    struct Case {
        const char* name;
        std::exception_ptr failure;
    };
    std::uint64_t begun = 0;
    for (const Case& c :
         {Case{"out of memory", std::make_exception_ptr(std::bad_alloc())},
          Case{"an error", std::make_exception_ptr(util::Error("the frame is no frame"))}}) {
        INFO(c.name);
        Met failing(farm::COORDINATOR);
        CHECK(daemon.serve(failing.near_that_fails(c.failure), false) == End::kLost);
        CHECK(daemon.totals().sessions == ++begun);
        CHECK(daemon.totals().now.empty());
        CHECK(daemon.totals().unfit == 0);
        Met next(farm::COORDINATOR);
        CHECK(next.far->send(bye()));
        CHECK(daemon.serve(std::move(next.near), false) == End::kBye);
        CHECK(daemon.totals().sessions == ++begun);
        CHECK(daemon.totals().busy == 0);
    }
}

TEST_CASE("a peer that is neither coordinator nor observer is counted as unfit",
          "[raytracer][farm][worker]") {
    farm::WorkerDaemon daemon({});
    Met worker(farm::WORKER);
    // It reads, as a peer does: the daemon waits for that before it ends the link.
    std::thread reading([&] {
        while (worker.far->receive()) {
        }
    });
    CHECK(daemon.serve(std::move(worker.near), false) == End::kLost);
    reading.join();
    CHECK(daemon.totals().unfit == 1);
    CHECK(daemon.totals().sessions == 0);
}
