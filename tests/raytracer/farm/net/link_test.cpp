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

TEST_CASE("much data goes both ways at once", "[common][net][link]") {
    Farm farm;
    const auto [dialled, accepted] = farm.pair();
    REQUIRE(accepted);
    constexpr std::size_t kFrame_bytes = 256 << 10;
    const auto send_all = [](net::Link& link) {
        for (std::uint64_t i = 0; i < 1000; ++i)
            if (!link.send(done(i, kFrame_bytes)))
                return false;
        return true;
    };
    const auto receive_all = [](net::Link& link) {
        for (std::uint64_t i = 0; i < 1000; ++i) {
            const auto frame = link.receive();
            if (!frame || frame->done().id() != i ||
                frame->done().result().size() != kFrame_bytes ||
                frame->done().result().back() != static_cast<char>('a' + i % 26))
                return false;
        }
        return true;
    };
    auto there = std::async(std::launch::async, send_all, std::ref(*dialled)),
         back = std::async(std::launch::async, send_all, std::ref(*accepted));
    auto arrived = std::async(std::launch::async, receive_all, std::ref(*accepted));
    CHECK(receive_all(*dialled));
    CHECK(arrived.get());
    CHECK(there.get());
    CHECK(back.get());
}
