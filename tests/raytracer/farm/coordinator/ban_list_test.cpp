#include "raytracer/farm/coordinator/known_workers.hpp"

#include <string>

#include "tests/catch.hpp"

using terravox::farm::BanList;

TEST_CASE("a worker that was dialled is banned by its address, under any name",
          "[raytracer][farm]") {
    BanList bans;
    bans.ban({"liar", "10.0.0.1:7878", "render-1:7878"});
    CHECK(bans.has({"liar", "10.0.0.1:7878", "render-1:7878"}));
    CHECK(bans.has({"another name", "10.0.0.9:1", "render-1:7878"}));
    CHECK_FALSE(bans.has({"liar", "10.0.0.1:7878", "render-2:7878"}));
    CHECK_FALSE(bans.has({"liar", "10.0.0.1:4000", ""}));
}

TEST_CASE("a worker that dialled in is banned by its name and host, from any port",
          "[raytracer][farm]") {
    BanList bans;
    CHECK_FALSE(bans.has({"liar", "10.0.0.1:4000", ""}));
    bans.ban({"liar", "10.0.0.1:4000", ""});
    CHECK(bans.has({"liar", "10.0.0.1:4000", ""}));
    CHECK(bans.has({"liar", "10.0.0.1:4001", ""}));
    CHECK_FALSE(bans.has({"honest", "10.0.0.1:4000", ""}));
    CHECK_FALSE(bans.has({"liar", "10.0.0.2:4000", ""}));
    CHECK_FALSE(bans.has({"liar", "10.0.0.1:4000", "10.0.0.1:4000"}));
}

TEST_CASE("a host with several banned workers is banned, one worker that is banned again is not",
          "[raytracer][farm]") {
    const std::string peer = GENERATE("10.0.0.1:4000", "[2001:db8::1]:4000");
    BanList bans;
    for (int i = 0; i < 2 * BanList::kMaxOfHost; ++i)
        bans.ban({"liar", peer, ""});
    CHECK_FALSE(bans.has({"honest", peer, ""}));
    for (int i = 1; i < BanList::kMaxOfHost; ++i) {
        CHECK_FALSE(bans.has({"honest", peer, ""}));
        bans.ban({"liar " + std::to_string(i), peer, ""});
    }
    CHECK(bans.has({"honest", peer, ""}));
    for (const char* other : {"10.0.0.2:4000", "[2001:db8::2]:4000"})
        CHECK_FALSE(bans.has({"honest", other, ""}));
}
