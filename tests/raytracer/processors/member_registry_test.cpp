#include "raytracer/processors/member_registry.hpp"

#include "tests/catch.hpp"
#include "tests/raytracer/processors/pool_parts.hpp"

using namespace terravox;
using namespace terravox::test;
using processors::MemberRegistry;

TEST_CASE("a member is found until it is removed, and its id is never used again",
          "[raytracer][sched]") {
    MemberRegistry members;
    const auto first = members.add(worker_spec(), false, at_s(0));
    CHECK(first != 0);
    REQUIRE(members.find(first) != nullptr);
    CHECK(members.find(first)->spec().name == "worker");
    CHECK(members.remove(first));
    CHECK(members.find(first) == nullptr);
    CHECK_FALSE(members.remove(first));
    CHECK(members.add(worker_spec(), false, at_s(0)) != first);
}

TEST_CASE("the checker is claimed once, and only where no member is trusted",
          "[raytracer][sched]") {
    MemberRegistry members;
    members.add(worker_spec(), false, at_s(0));
    SECTION("no member is trusted") {
        CHECK(members.claim_checker());
        CHECK_FALSE(members.claim_checker());
    }
    SECTION("a trusted member is there, for a while") {
        const auto trusted = members.add(trusted_spec(), false, at_s(0));
        CHECK_FALSE(members.claim_checker());
        members.remove(trusted);
        CHECK(members.claim_checker());
    }
}

TEST_CASE("the checker takes work only where it stands in", "[raytracer][sched]") {
    MemberRegistry members;
    const auto checker = members.add(trusted_spec(), true, at_s(0));
    CHECK_FALSE(members.has_workers());
    CHECK_FALSE(members.takes_work(*members.find(checker)));
    CHECK_FALSE(members.traces_here());
    members.stand_in();
    CHECK(members.stands_in());
    CHECK_FALSE(members.has_workers());
    CHECK(members.takes_work(*members.find(checker)));
    CHECK(members.traces_here());
}

TEST_CASE("this process traces while a trusted member takes work", "[raytracer][sched]") {
    MemberRegistry members;
    const auto worker = members.add(worker_spec(), false, at_s(0));
    CHECK(members.has_workers());
    CHECK(members.takes_work(*members.find(worker)));
    CHECK_FALSE(members.traces_here());
    const auto trusted = members.add(trusted_spec(), false, at_s(0));
    CHECK(members.traces_here());
    members.find(trusted)->pause(true);
    CHECK_FALSE(members.traces_here());
}

TEST_CASE("the speed of all is that of members that take work", "[raytracer][sched]") {
    MemberRegistry members;
    const auto first = members.add(worker_spec(), false, at_s(0));
    const auto second = members.add(worker_spec(), false, at_s(0));
    members.add(worker_spec(), false, at_s(0));
    CHECK(members.pixels_per_s() == 0);
    set_speed(*members.find(first), 1000, at_s(1));
    set_speed(*members.find(second), 500, at_s(1));
    CHECK(members.pixels_per_s() == Approx(1500));
    members.find(first)->drain();
    CHECK(members.pixels_per_s() == Approx(500));
}
