#include "voxelserver/make/worlds/remote/retry.hpp"

#include <algorithm>
#include <random>

#include "tests/catch.hpp"

using namespace terravox;
using namespace std::chrono_literals;

namespace {

const remote::Retry::Clock::time_point kStart{1000s};

}  // namespace

TEST_CASE("each kind of failure is retried as often as is useful", "[raytracer][retry]") {
    struct Case {
        const char* name;
        remote::FailureKind kind;
        int tries;
        int hopeless_tries;
    };
    const auto c = GENERATE(values<Case>({
        {"lost", remote::FailureKind::kLost, 5, 1},
        {"failed", remote::FailureKind::kFailed, 3, 1},
        {"damaged", remote::FailureKind::kDamaged, 4, 1},
        {"busy", remote::FailureKind::kBusy, 1000, 1000},
    }));
    DYNAMIC_SECTION(c.name) {
        for (const bool is_reachable : {true, false}) {
            remote::Retry retry(kStart, 24h, is_reachable);
            int tries = 1;
            while (tries < 1000 && retry.wait_after(c.kind, kStart, std::nullopt, 0.5))
                ++tries;
            CHECK(tries == (is_reachable ? c.tries : c.hopeless_tries));
            CHECK(retry.tries() == (tries == 1000 ? 999 : tries));
        }
    }
}

TEST_CASE("waits grow up to a limit, and are spread", "[raytracer][retry]") {
    remote::Retry low(kStart, 24h), middle(kStart, 24h), high(kStart, 24h);
    remote::Retry::Milliseconds before{0};
    for (int i = 0; i < 20; ++i) {
        const auto a = *low.wait_after(remote::FailureKind::kBusy, kStart, std::nullopt, 0);
        const auto b = *middle.wait_after(remote::FailureKind::kBusy, kStart, std::nullopt, 0.5);
        const auto c = *high.wait_after(remote::FailureKind::kBusy, kStart, std::nullopt, 0.999);
        CHECK(a < b);
        CHECK(b < c);
        CHECK((b > before || b == 10s));
        CHECK(c <= 15s);
        before = b;
    }
    CHECK(before == 10s);
}

TEST_CASE("a server's wish is heeded, within reason", "[raytracer][retry]") {
    struct Case {
        const char* name;
        std::chrono::seconds wish;
        remote::Retry::Milliseconds least;
        remote::Retry::Milliseconds most;
    };
    const auto c = GENERATE(values<Case>({
        {"at once", 0s, 50ms, 150ms},
        {"a second", 1s, 1s, 1250ms},
        {"half a minute", 30s, 30s, 37500ms},
        {"an hour", 3600s, 60s, 75s},
        {"for ever", std::chrono::seconds::max(), 60s, 75s},
        {"in the past", std::chrono::seconds::min(), 50ms, 150ms},
    }));
    DYNAMIC_SECTION(c.name) {
        for (const double chance : {0.0, 0.3, 0.999999}) {
            remote::Retry retry(kStart, 24h);
            const auto wait = retry.wait_after(remote::FailureKind::kBusy, kStart, c.wish, chance);
            REQUIRE(wait);
            CHECK(*wait >= c.least);
            CHECK(*wait <= c.most);
        }
    }
}

TEST_CASE("no plan outlasts its timeout", "[raytracer][retry]") {
    std::mt19937 random(20260621);
    for (int run = 0; run < 2000; ++run) {
        const auto timeout = remote::Retry::Milliseconds(1 + static_cast<int>(random() % 400'000));
        INFO("run " << run << ", timeout " << timeout.count() << " ms");
        remote::Retry retry(kStart, timeout);
        auto now = kStart;
        int tries = 0;
        while (true) {
            const auto left = retry.time_left(now);
            CHECK(left >= 1ms);
            CHECK((now + left <= kStart + timeout || left == 1ms));
            now += std::min(left, remote::Retry::Milliseconds(static_cast<int>(random() % 20'000)));
            const auto wish = random() % 2 == 0
                                  ? std::nullopt
                                  : std::optional(std::chrono::seconds(random() % 100));
            const auto wait = retry.wait_after(remote::FailureKind::kBusy, now, wish,
                                               static_cast<double>(random() % 1000) / 1000);
            if (!wait)
                break;
            now += *wait;
            CHECK(now < kStart + timeout);
            REQUIRE(++tries < 10'000);
        }
    }
}
