#include "raytracer/farm/net/link.hpp"

#include <future>
#include <thread>

#include "tests/catch.hpp"
#include "tests/raytracer/farm/net/farm.hpp"

using namespace terravox;
using namespace terravox::test;
using namespace std::chrono_literals;

TEST_CASE("frames arrive in order, both ways", "[common][net][link]") {
    Farm farm;
    const auto [dialled, accepted] = farm.pair();
    REQUIRE(accepted);
    for (std::uint64_t i = 0; i < 2000; ++i) {
        REQUIRE(dialled->send(ping(i)));
        REQUIRE(accepted->send(ping(i + 5000)));
    }
    for (std::uint64_t i = 0; i < 2000; ++i) {
        const auto there = accepted->receive(), back = dialled->receive();
        REQUIRE(there);
        REQUIRE(back);
        REQUIRE(there->ping().stamp() == i);
        REQUIRE(back->ping().stamp() == i + 5000);
    }
    CHECK(dialled->why_ended().empty());
    CHECK(dialled->traffic().received_bytes == accepted->traffic().sent_bytes);
    CHECK(dialled->peer() == farm.address().text());
    CHECK_THAT(accepted->peer(), contains("127.0.0.1:"));
}
