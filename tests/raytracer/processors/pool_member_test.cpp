#include "raytracer/processors/pool_member.hpp"

#include "tests/catch.hpp"
#include "tests/raytracer/processors/pool_parts.hpp"

using namespace terravox;
using namespace terravox::test;
using processors::PoolMember;

namespace {

std::string state_of(const PoolMember& member) {
    return member.status(1, 0, at_s(1)).state;
}

}  // namespace

TEST_CASE("the state of a member names what keeps it from work first", "[raytracer][sched]") {
    PoolMember member(worker_spec(), false, at_s(0));
    CHECK(state_of(member) == "waiting");
    member.on_lease(at_s(0));
    CHECK(state_of(member) == "working");
    member.pause(true);
    CHECK(state_of(member) == "paused");
    member.drain();
    CHECK(state_of(member) == "draining");
    CHECK(member.set_late());
    CHECK(state_of(member) == "late");
}

TEST_CASE("a member is available unless it is paused, draining or late", "[raytracer][sched]") {
    PoolMember member(worker_spec(), false, at_s(0));
    CHECK(member.is_available());
    SECTION("paused, until it is resumed") {
        member.pause(true);
        CHECK_FALSE(member.is_available());
        member.pause(false);
        CHECK(member.is_available());
    }
    SECTION("paused from the beginning") {
        processors::MemberSpec spec = worker_spec();
        spec.paused = true;
        CHECK_FALSE(PoolMember(spec, false, at_s(0)).is_available());
    }
    SECTION("draining, for good") {
        member.drain();
        CHECK_FALSE(member.is_available());
    }
    SECTION("late, until it answers") {
        CHECK(member.set_late());
        CHECK_FALSE(member.is_available());
        member.on_answer(1);
        CHECK(member.is_available());
    }
}

TEST_CASE("a late member stays on probation until it answers, though others did its work",
          "[raytracer][sched]") {
    PoolMember member(worker_spec(), false, at_s(0));
    CHECK_FALSE(member.is_on_probation());
    CHECK(member.set_late());
    CHECK_FALSE(member.set_late());
    member.on_idle(at_s(1));
    CHECK(member.is_available());
    CHECK(member.is_on_probation());
    CHECK(member.set_late());
    member.on_answer(1);
    CHECK_FALSE(member.is_on_probation());
}

TEST_CASE("a request for a check holds for one band", "[raytracer][sched]") {
    PoolMember member(worker_spec(), false, at_s(0));
    CHECK_FALSE(member.take_check_request());
    member.request_check();
    CHECK(member.take_check_request());
    CHECK_FALSE(member.take_check_request());
}

TEST_CASE("a member counts its bands, its speed and its share of time with work",
          "[raytracer][sched]") {
    processors::MemberSpec spec = trusted_spec();
    spec.latency_s = [] { return 0.25; };
    PoolMember member(spec, false, at_s(10));
    member.on_lease(at_s(12));
    member.count_time(at_s(13));
    member.on_answer(4096);
    member.add_band(4096);
    member.on_idle(at_s(13));
    const processors::MemberStatus status = member.status(7, 3, at_s(14));
    CHECK(status.id == 7);
    CHECK(status.name == "here");
    CHECK(status.bands == 1);
    CHECK(status.pixels == 4096);
    CHECK(status.pixels_per_s == Approx(4096));
    CHECK(status.busy_share == Approx(0.25));
    CHECK(status.latency_s == 0.25);
    CHECK(status.leases == 3);
}

TEST_CASE("a member that claims no threads and no capacity has one of each", "[raytracer][sched]") {
    processors::MemberSpec spec = worker_spec(0);
    spec.threads = 0;
    const PoolMember member(spec, false, at_s(0));
    CHECK(member.threads() == 1);
    CHECK(member.max_leases() == 1);
}
