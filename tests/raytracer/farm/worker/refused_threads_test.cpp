// What becomes of a farm when the system refuses it a thread (ulimit -u, a container's pids.max).
#include <dlfcn.h>
#include <pthread.h>

#include <atomic>
#include <cerrno>
#include <functional>
#include <string_view>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/raytracer/farm/worker/fake_coordinator.hpp"

using namespace terravox;
using namespace terravox::test;

namespace {

/// Number of threads that start before one is refused; below 0: none is refused.
std::atomic<int> g_until_refused{-1};

/// Refuses one thread, as the system does when there are too many.
class RefusedThread {
public:
    /// @param given number of threads that can be started before
    explicit RefusedThread(int given) { g_until_refused = given; }
    ~RefusedThread() { g_until_refused = -1; }
    RefusedThread(const RefusedThread&) = delete;
    RefusedThread& operator=(const RefusedThread&) = delete;
    /// Whether a thread was refused.
    [[nodiscard]] bool was_refused() const noexcept { return g_until_refused < 0; }
};

/// Whether the code at this address is of the library that has std::thread. Others, as gRPC, end
/// the program without threads.
bool is_of_std_thread(const void* code) noexcept {
    Dl_info info{};
    if (::dladdr(code, &info) == 0 || info.dli_fname == nullptr)
        return false;
    return std::string_view(info.dli_fname).find("libstdc++") != std::string_view::npos;
}

constexpr const char* kNoMore = "the system gives no more threads";

}  // namespace

/// Takes the place of the system's function for this program, which it calls.
extern "C" int pthread_create(pthread_t* thread, const pthread_attr_t* attributes,
                              void* (*run)(void*), void* argument) noexcept {
    using Create = int (*)(pthread_t*, const pthread_attr_t*, void* (*)(void*), void*);
    static const auto create = reinterpret_cast<Create>(::dlsym(RTLD_NEXT, "pthread_create"));
    if (g_until_refused >= 0 && is_of_std_thread(__builtin_return_address(0)) &&
        g_until_refused-- == 0)
        return EAGAIN;
    return create(thread, attributes, run, argument);
}

TEST_CASE("whichever thread of a picture cannot be started, a worker reports that and continues",
          "[raytracer][farm][worker]") {
    const auto is_heartbeat = [](const farm::Frame& f) { return f.has_heartbeat(); };
    constexpr int kThreads = 9;  // with two that collect
    int given = 0;
    for (bool refused = true; refused; ++given) {
        INFO("after " << given << " threads");
        FakeCoordinator coordinator(kThreads, std::size_t{64} << 20);
        const farm::PictureSpec spec = make_spec(false);
        REQUIRE(coordinator.next(is_heartbeat));  // all that a link needs is there
        const RefusedThread one(given);
        coordinator.begin(spec);
        coordinator.lease({0, 0, 0, 0, 97, 53, 1, false, 0, 0}, 77);
        // A tile that is traced requests boxes.
        const auto answer = coordinator.next(
            [](const farm::Frame& f) { return f.has_failed() || f.has_need_box(); });
        REQUIRE(answer);
        refused = one.was_refused();
        CHECK(answer->has_failed() == refused);
        if (refused)
            CHECK_THAT(answer->failed().reason(), contains(kNoMore));
        CHECK(coordinator.next(is_heartbeat));
    }
    CHECK(
        given >
        kThreads +
            3);  // the picture's own, those that trace, two that collect, and one that loads boxes
}

TEST_CASE("a worker without a thread for its heartbeats ends the link with an error",
          "[raytracer][farm][worker]") {
    auto [mine, theirs] = net::link_pair();
    farm::WorkerShared shared(std::size_t{1} << 20, 1);
    {
        farm::WorkerSession session(std::move(theirs), "the test", {}, shared);
        const RefusedThread one(0);
        std::string why;
        CHECK_THROWS_WITH(session.run(why),
                          contains("start a thread for heartbeats") && contains(kNoMore));
    }
    CHECK_FALSE(mine->receive());
}

TEST_CASE("daemons and farms that are refused a thread at their start are errors",
          "[raytracer][farm][worker]") {
    const net::Credentials credentials{
        .token = "token-of-the-tests-7f3a9c51e8b2d604", .ca = {}, .certificate = {}, .key = {}};
    const std::vector<sockets::Address> nobody{{.host = "127.0.0.1", .port = 1},
                                               {.host = "127.0.0.1", .port = 2}};
    const auto begin_daemon = [&] {
        farm::WorkerDaemonOptions options;
        options.join = nobody;
        options.credentials = credentials;
        const farm::WorkerDaemon daemon(options);
    };
    Job job(farm_scene());
    const auto begin_farm = [&] {
        farm::FarmOptions options;
        options.dial = nobody;
        options.credentials = credentials;
        const terravox::farm::Farm farm(options, job.blocks, {});
    };
    struct Case {
        const char* name;
        std::function<void()> begin;
        int least;  ///< threads
    };
    for (const Case& c : {Case{"daemon", begin_daemon, 2}, Case{"farm", begin_farm, 3}}) {
        int given = 0;
        for (bool refused = true; refused; ++given) {
            INFO(c.name << " after " << given << " threads");
            const RefusedThread one(given);
            std::string error;
            try {
                c.begin();
            } catch (const std::exception&) {
                error = util::to_message(std::current_exception());
            }
            refused = one.was_refused();
            CHECK((error.find(kNoMore) != std::string::npos) == refused);
        }
        CHECK(given > c.least);
    }
}
