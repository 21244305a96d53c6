#include "raytracer/farm/processors/lease_planner.hpp"

#include <algorithm>

#include "tests/catch.hpp"
#include "tests/raytracer/farm/processors/pool_parts.hpp"

using namespace terravox;
using namespace terravox::test;
using processors::LeaseBook;
using processors::LeasePlanner;
using processors::MemberId;

namespace {

constexpr std::chrono::seconds kMinDeadline{10};

/// A planner with its book and its members.
struct PlannerBench {
    LeaseBook book;
    processors::MemberRegistry members;
    LeasePlanner planner{book, members, kMinDeadline};

    void add_tiles(std::uint32_t count, int rows) {
        for (std::uint32_t i = 0; i < count; ++i)
            book.add(tile_of_rows(i, rows));
    }
    /// @param pixels_per_s  its speed at the time 0; 0: not known
    MemberId add(processors::MemberSpec spec, std::size_t pixels_per_s = 0) {
        const MemberId id = members.add(std::move(spec), false, at_s(-1));
        if (pixels_per_s > 0)
            set_speed(*members.find(id), pixels_per_s, at_s(0));
        return id;
    }
    [[nodiscard]] std::size_t wanted_by(MemberId id) const {
        return planner.wanted_pixels(*members.find(id));
    }
    [[nodiscard]] std::vector<LeasePlanner::Grant> plan(double now_s) {
        return planner.plan(at_s(now_s), false);
    }
};

std::size_t count_bands(const std::vector<LeasePlanner::Grant>& grants, MemberId id) {
    return static_cast<std::size_t>(
        std::count_if(grants.begin(), grants.end(), [&](const auto& g) { return g.member == id; }));
}

}  // namespace

TEST_CASE("a member that may not work gets nothing", "[raytracer][sched]") {
    PlannerBench bench;
    bench.add_tiles(16, 256);
    const MemberId id = bench.add(worker_spec());
    processors::PoolMember& member = *bench.members.find(id);
    SECTION("it is paused") {
        member.pause(true);
    }
    SECTION("it is draining") {
        member.drain();
    }
    SECTION("it is late") {
        CHECK(member.set_late());
    }
    CHECK(bench.plan(0).empty());
}

TEST_CASE("a member on probation gets one band at a time", "[raytracer][sched]") {
    PlannerBench bench;
    bench.add_tiles(16, 256);
    const MemberId id = bench.add(worker_spec());
    CHECK(bench.members.find(id)->set_late());
    bench.members.find(id)->on_idle(at_s(0));
    CHECK(bench.plan(0).size() == 1);
    CHECK(bench.plan(0).empty());
}

TEST_CASE("nothing but checks is leased while results wait, and checks to trusted members only",
          "[raytracer][sched]") {
    PlannerBench bench;
    bench.add_tiles(16, 256);
    bench.book.check(77, tile_of_rows(0, 8), 0, {});
    bench.add(worker_spec());
    const MemberId trusted = bench.add(trusted_spec());
    const auto grants = bench.planner.plan(at_s(0), true);
    REQUIRE(grants.size() == 1);
    CHECK(grants.front().member == trusted);
    CHECK(grants.front().band == tile_of_rows(0, 8));
    CHECK(grants.front().processor == bench.members.find(trusted)->spec().processor);
    CHECK_FALSE(bench.book.checks_wait());
}

TEST_CASE("the deadline of a lease is three times what the member should take, or the least",
          "[raytracer][sched]") {
    struct Case {
        const char* name;
        std::size_t pixels_per_s;
        double deadline_s;
    };
    const auto c = GENERATE(values<Case>({
        {"unknown speed", 0, 10},
        {"a fast member", 100'000, 10},
        {"a slow member", 100, 3 * 1024 / 100.0},
    }));
    DYNAMIC_SECTION(c.name) {
        PlannerBench bench;
        bench.add_tiles(1, 16);
        const MemberId id = bench.add(worker_spec(), c.pixels_per_s);
        CHECK(bench.plan(0).size() == 1);
        CHECK(bench.book.expire(at_s(c.deadline_s - 0.01)).empty());
        CHECK(bench.book.expire(at_s(c.deadline_s + 0.01)) == std::vector{id});
    }
}

TEST_CASE("leases of trusted members have no deadline", "[raytracer][sched]") {
    PlannerBench bench;
    bench.add_tiles(1, 16);
    bench.add(trusted_spec());
    CHECK(bench.plan(0).size() == 1);
    CHECK(bench.book.expire(at_s(1'000'000)).empty());
}

TEST_CASE("an idle member repeats a lease, unless its owner is about to be done",
          "[raytracer][sched]") {
    PlannerBench bench;
    bench.add_tiles(1, 16);
    const MemberId owner = bench.add(worker_spec(1), 10'240);
    CHECK(count_bands(bench.plan(0), owner) == 1);
    const MemberId idle = bench.add(worker_spec(), 10'240);
    CHECK(bench.plan(0).empty());
    const auto grants = bench.plan(1);
    REQUIRE(grants.size() == 1);
    CHECK(grants.front().member == idle);
    CHECK(grants.front().repeated);
    CHECK(grants.front().band == tile_of_rows(0, 16));
    CHECK(bench.plan(2).empty());
}

TEST_CASE(
    "bands of a lost member are leased at once to the member that finishes first, whatever it has",
    "[raytracer][sched]") {
    PlannerBench bench;
    bench.add_tiles(16, 256);
    bench.add(worker_spec(1), 1000);
    const MemberId fast = bench.add(worker_spec(1), 100'000);
    bench.add(trusted_spec(), 1'000'000);
    (void)bench.plan(0);
    CHECK(bench.plan(0).empty());
    bench.planner.add_returned(2);
    const auto grants = bench.plan(0);
    CHECK(grants.size() == 2);
    CHECK(count_bands(grants, fast) == 2);
    CHECK(bench.plan(0).empty());
}
