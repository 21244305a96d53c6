#include "raytracer/farm/coordinator/known_workers.hpp"

#include <string>
#include <vector>

#include "tests/catch.hpp"

using terravox::farm::DialledAddresses;

TEST_CASE("an address is dialled once at a time", "[raytracer][farm]") {
    DialledAddresses dialled;
    const auto turn = dialled.add("b:1");
    REQUIRE(turn);
    CHECK_FALSE(dialled.add("b:1"));
    const auto other = dialled.add("a:1");
    REQUIRE(other);
    CHECK(*other != *turn);
    CHECK(dialled.list() == std::vector<std::string>{"a:1", "b:1"});
    CHECK(dialled.has("b:1"));
    CHECK(dialled.has("b:1", *turn));
    CHECK_FALSE(dialled.has("b:1", *other));
    dialled.remove("b:1");
    CHECK_FALSE(dialled.has("b:1"));
    CHECK_FALSE(dialled.has("b:1", *turn));
    dialled.remove("never:1");
    CHECK(dialled.list() == std::vector<std::string>{"a:1"});
}

TEST_CASE("a former turn neither continues nor removes the address that is dialled again",
          "[raytracer][farm]") {
    DialledAddresses dialled;
    const auto former = dialled.add("a:1");
    REQUIRE(former);
    dialled.remove("a:1");
    const auto turn = dialled.add("a:1");
    REQUIRE(turn);
    CHECK(*former != *turn);
    CHECK_FALSE(dialled.has("a:1", *former));
    dialled.remove("a:1", *former);
    CHECK(dialled.has("a:1", *turn));
    dialled.remove("a:1", *turn);
    CHECK(dialled.list().empty());
}
