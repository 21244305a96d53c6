// A name service that does not answer. A program of its own: its getaddrinfo() stands before the
// one of the C library.
#include <dlfcn.h>
#include <netdb.h>

#include <condition_variable>
#include <functional>
#include <future>
#include <mutex>
#include <stop_token>
#include <string_view>

#include "common/thread/start_threads.hpp"
#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "voxelserver/make/worlds/remote/http_access.hpp"
#include "voxelserver/make/worlds/remote/http_client.hpp"

using namespace terravox;
using terravox::test::contains;

namespace {

constexpr std::string_view kSlowHost = "slow.test";

/// Look-ups of kSlowHost: none ends before open().
class Gate {
public:
    void pass() {
        std::unique_lock lock(m_mutex);
        ++m_waiting;
        m_changed.notify_all();
        m_changed.wait(lock, [&] { return m_open; });
        --m_waiting;
        m_changed.notify_all();
    }
    void wait_for_one() {
        std::unique_lock lock(m_mutex);
        m_changed.wait(lock, [&] { return m_waiting > 0; });
    }
    [[nodiscard]] bool holds_one() {
        const std::lock_guard lock(m_mutex);
        return m_waiting > 0;
    }
    /// Lets all through that wait, and closes again.
    void let_through() {
        std::unique_lock lock(m_mutex);
        m_open = true;
        m_changed.notify_all();
        m_changed.wait(lock, [&] { return m_waiting == 0; });
        m_open = false;
    }

private:
    std::mutex m_mutex;
    std::condition_variable m_changed;
    int m_waiting = 0;
    bool m_open = false;
};

// Never destroyed: threads that were left behind may outlive main().
Gate& gate() {
    static auto* const made = new Gate;
    return *made;
}

struct LetThrough {
    ~LetThrough() { gate().let_through(); }
};

}  // namespace

extern "C" int getaddrinfo(const char* node, const char* service, const addrinfo* hints,
                           addrinfo** found) {
    const bool by_number = hints != nullptr && (hints->ai_flags & AI_NUMERICHOST) != 0;
    if (node != nullptr && node == kSlowHost && !by_number) {
        gate().pass();
        return EAI_AGAIN;
    }
    static const auto real =
        reinterpret_cast<decltype(&::getaddrinfo)>(::dlsym(RTLD_NEXT, "getaddrinfo"));
    return real(node, service, hints, found);
}

TEST_CASE("an uninterruptible call is left behind when a stop is requested",
          "[raytracer][world][names]") {
    std::stop_source stop;
    SECTION("it ends in time") {
        CHECK(thread::call_until_stopped([] { return 7; }, stop.get_token()) == 7);
    }
    SECTION("it throws") {
        CHECK_THROWS_WITH(
            thread::call_until_stopped([]() -> int { throw util::Error("no"); }, stop.get_token()),
            "no");
    }
    SECTION("it does not end") {
        const LetThrough after;
        auto result = std::async(std::launch::async, [&] {
            return thread::call_until_stopped([] { return gate().pass(), 7; }, stop.get_token());
        });
        gate().wait_for_one();
        stop.request_stop();
        CHECK(result.get() == std::nullopt);
        CHECK(gate().holds_one());
    }
}

TEST_CASE("a stop request does not wait for the name service", "[raytracer][world][names]") {
    std::stop_source stop;
    remote::HttpClient client;
    const std::string url = "http://" + std::string(kSlowHost) + ":9";
    struct Case {
        const char* name;
        std::function<void()> call;
    };
    const auto c = GENERATE_REF(values<Case>({
        {"look-up",
         [&] { (void)remote::ranges_of_host(remote::HttpOrigin::of(url), stop.get_token()); }},
        {"request", [&] { (void)client.get(url, {}); }},
    }));
    DYNAMIC_SECTION(c.name) {
        const LetThrough after;
        auto result = std::async(std::launch::async, c.call);
        gate().wait_for_one();
        stop.request_stop();
        client.stop();
        CHECK_THROWS_WITH(result.get(), contains(std::string(kSlowHost)) && contains("stopped"));
        CHECK(gate().holds_one());
    }
}

TEST_CASE("a name that the name service gives up on is a name that leads nowhere",
          "[raytracer][world][names]") {
    auto result = std::async(std::launch::async, [] {
        return remote::ranges_of_host(remote::HttpOrigin::of("http://" + std::string(kSlowHost)));
    });
    gate().wait_for_one();
    gate().let_through();
    CHECK(result.get().empty());
    CHECK(remote::ranges_of_host(remote::HttpOrigin::of("http://127.0.0.1:9"))
              .holds(remote::AddressRange::kLoopback));
}
