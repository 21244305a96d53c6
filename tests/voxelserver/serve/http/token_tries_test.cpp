#include "voxelserver/serve/http/request_check.hpp"

#include "tests/catch.hpp"

using namespace terravox;
using namespace std::chrono_literals;
using http::TokenTries;

namespace {

const TokenTries::Time kStart{1000h};

/// @return how many wrong tokens in a row count, at one time
int count_tries(TokenTries& tries, const std::string& address, TokenTries::Time now) {
    int out = 0;
    while (out < 1000 && tries.count(address, false, now))
        ++out;
    return out;
}

}  // namespace

TEST_CASE("an address may try some wrong tokens at once, then one every second",
          "[voxelserver][http][token]") {
    TokenTries tries;
    CHECK(count_tries(tries, "192.0.2.7", kStart) == TokenTries::kMax);
    CHECK(count_tries(tries, "192.0.2.7", kStart + 999ms) == 0);
    CHECK(count_tries(tries, "192.0.2.7", kStart + 1s) == 1);
    CHECK(count_tries(tries, "192.0.2.7", kStart + 1s) == 0);
    CHECK(count_tries(tries, "192.0.2.7", kStart + 4s) == 3);
    CHECK(count_tries(tries, "192.0.2.7", kStart + 1h) == TokenTries::kMax);
}

TEST_CASE("addresses are limited by themselves, those of an IPv6 network together",
          "[voxelserver][http][token]") {
    struct Case {
        const char* other;
        bool is_the_same;
    };
    const auto c = GENERATE(values<Case>({
        {"192.0.2.8", false},
        {"2001:db8:1::1", false},
        {"2001:db8::2", true},
        {"2001:db8::ffff:0:0:1", true},
        {"2001:db8:0:1::1", false},
    }));
    DYNAMIC_SECTION(c.other) {
        TokenTries tries;
        CHECK(count_tries(tries, "2001:db8::1", kStart) == TokenTries::kMax);
        CHECK(tries.count(c.other, true, kStart) != c.is_the_same);
    }
}

TEST_CASE("an address that has shown the right token is not limited for some time",
          "[voxelserver][http][token]") {
    TokenTries tries;
    CHECK(tries.count("192.0.2.7", true, kStart));
    CHECK(count_tries(tries, "192.0.2.7", kStart + 9min + 50s) == 1000);
    CHECK(count_tries(tries, "192.0.2.7", kStart + 10min) == 10);
    CHECK(count_tries(tries, "192.0.2.7", kStart + 11min) == TokenTries::kMax);
}

TEST_CASE("addresses without end fill no memory, and the latest are remembered",
          "[voxelserver][http][token]") {
    TokenTries tries;
    const auto address = [](std::size_t i) {
        return "10.0." + std::to_string(i / 256) + "." + std::to_string(i % 256);
    };
    for (std::size_t i = 0; i < TokenTries::kMaxKept + 10; ++i)
        CHECK(count_tries(tries, address(i), kStart + std::chrono::milliseconds(i / 10)) ==
              TokenTries::kMax);
    CHECK_FALSE(tries.count(address(TokenTries::kMaxKept + 9), false, kStart + 500ms));
    CHECK(count_tries(tries, address(0), kStart + 500ms) == TokenTries::kMax);
}
