#include "raytracer/processors/lease_planner.hpp"

#include <algorithm>

#include "tests/catch.hpp"
#include "tests/raytracer/processors/pool_parts.hpp"

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

std::size_t bands_of(const std::vector<LeasePlanner::Grant>& grants, MemberId id) {
    return static_cast<std::size_t>(
        std::count_if(grants.begin(), grants.end(), [&](const auto& g) { return g.member == id; }));
}

}  // namespace

TEST_CASE("a member of unknown speed gets little, a thread of this process more",
          "[raytracer][sched]") {
    PlannerBench bench;
    bench.add_tiles(16, 256);
    const MemberId worker = bench.add(worker_spec());
    const MemberId trusted = bench.add(trusted_spec());
    CHECK(bench.wanted_by(worker) == 2 * 1024);
    CHECK(bench.wanted_by(trusted) == 6 * 4096);
    const auto grants = bench.plan(0);
    CHECK(bands_of(grants, worker) == 2);
    CHECK(bench.book.load_of(worker).pixels == 2 * 1024);
    CHECK(bench.book.load_of(trusted).pixels >= 6 * 4096);
    CHECK(bench.plan(0).empty());
}

TEST_CASE("a member has leased as much at once as it computes during a round trip",
          "[raytracer][sched]") {
    PlannerBench bench;
    bench.add_tiles(100, 256);
    processors::MemberSpec far = worker_spec();
    far.latency_s = [] { return 0.5; };
    const MemberId near_by = bench.add(worker_spec(), 100'000);
    const MemberId far_away = bench.add(far, 100'000);
    CHECK(bench.wanted_by(near_by) == 30'000);
    CHECK(bench.wanted_by(far_away) == 130'000);
}

TEST_CASE("near the end members get half of their share of what is left", "[raytracer][sched]") {
    PlannerBench bench;
    bench.add_tiles(10, 160);
    const MemberId slow = bench.add(worker_spec(), 1'000'000);
    const MemberId fast = bench.add(worker_spec(), 3'000'000);
    constexpr double kLeft = 64 * 160 * 10;
    CHECK(static_cast<double>(bench.wanted_by(slow)) == Approx(kLeft / 8).margin(1));
    CHECK(static_cast<double>(bench.wanted_by(fast)) == Approx(kLeft * 3 / 8).margin(1));
}

TEST_CASE("the capacity of a processor bounds its leases", "[raytracer][sched]") {
    PlannerBench bench;
    bench.add_tiles(16, 256);
    const MemberId one = bench.add(worker_spec(1), 1'000'000);
    CHECK(bands_of(bench.plan(0), one) == 1);
}

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
    CHECK(bands_of(bench.plan(0), owner) == 1);
    const MemberId idle = bench.add(worker_spec(), 10'240);
    CHECK(bench.plan(0).empty());
    const auto grants = bench.plan(1);
    REQUIRE(grants.size() == 1);
    CHECK(grants.front().member == idle);
    CHECK(grants.front().repeated);
    CHECK(grants.front().band == tile_of_rows(0, 16));
    CHECK(bench.plan(2).empty());
}

TEST_CASE("an idle member repeats the lease that would take longest", "[raytracer][sched]") {
    PlannerBench bench;
    bench.add_tiles(2, 16);
    const MemberId slow = bench.add(worker_spec(1), 500);
    const MemberId slower = bench.add(worker_spec(1), 100);
    CHECK(bench.plan(0).size() == 2);
    const auto open = bench.book.open_leases();
    const auto longest = std::find_if(open.begin(), open.end(),
                                      [&](const auto& lease) { return lease.member == slower; });
    REQUIRE(longest != open.end());
    CHECK(bench.book.load_of(slow).leases == 1);
    const MemberId fast = bench.add(worker_spec(1), 100'000);
    const auto grants = bench.plan(0.01);
    REQUIRE(grants.size() == 1);
    CHECK(grants.front().member == fast);
    CHECK(grants.front().band == longest->band);
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
    CHECK(bands_of(grants, fast) == 2);
    CHECK(bench.plan(0).empty());
}

TEST_CASE("bands of a lost member are leased like others where no speed is known",
          "[raytracer][sched]") {
    PlannerBench bench;
    bench.add_tiles(16, 256);
    bench.add(worker_spec(1));
    CHECK(bench.plan(0).size() == 1);
    bench.planner.add_returned(2);
    CHECK(bench.plan(0).empty());
}
