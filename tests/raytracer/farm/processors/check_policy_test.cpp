#include "raytracer/farm/processors/pool_results.hpp"

#include <set>
#include <vector>

#include "tests/catch.hpp"
#include "tests/raytracer/farm/processors/pool_parts.hpp"

using namespace terravox;
using namespace terravox::test;
using processors::CheckPolicy;
using processors::PoolMember;

namespace {

/// A worker whose first band has been answered.
PoolMember experienced_worker() {
    PoolMember out(worker_spec(), false, at_s(0));
    out.add_band(1);
    return out;
}

}  // namespace

TEST_CASE("the first band of a member is checked, others by chance", "[raytracer][sched]") {
    const auto seed = GENERATE(range(1u, 10u));
    INFO("seed " << seed);
    CheckPolicy policy(10, seed);
    PoolMember member(worker_spec(), false, at_s(0));
    CHECK(policy.is_due(member));
    CHECK(policy.is_due(member));
    member.add_band(1);
    int checked = 0;
    for (int i = 0; i < 10'000; ++i)
        checked += policy.is_due(member) ? 1 : 0;
    CHECK(checked > 800);
    CHECK(checked < 1200);
}

TEST_CASE("trusted members are never checked, nor any member without checks",
          "[raytracer][sched]") {
    PoolMember trusted(trusted_spec(), false, at_s(0));
    CHECK_FALSE(CheckPolicy(1, 1).is_due(trusted));
    PoolMember member(worker_spec(), false, at_s(0));
    CHECK_FALSE(CheckPolicy(0, 1).is_due(member));
    CHECK_FALSE(CheckPolicy(-1, 1).is_due(member));
}

TEST_CASE("the same seed gives the same choice, another seed another", "[raytracer][sched]") {
    const auto choices = [](std::uint64_t seed) {
        CheckPolicy policy(2, seed);
        PoolMember member = experienced_worker();
        std::vector<bool> out;
        for (int i = 0; i < 64; ++i)
            out.push_back(policy.is_due(member));
        return out;
    };
    CHECK(choices(5) == choices(5));
    CHECK(choices(5) != choices(7));
}

TEST_CASE("rows to check are whole blocks within the band, anywhere in it", "[raytracer][sched]") {
    struct Case {
        const char* name;
        int y0;
        int y1;
        int step;
        std::set<std::pair<int, int>> rows;
    };
    const auto c = GENERATE(values<Case>({
        {"blocks of eight rows", 16, 40, 1, {{16, 24}, {24, 32}, {32, 40}}},
        {"a last block that is cut", 0, 13, 1, {{0, 8}, {8, 13}}},
        {"fewer rows than a block", 0, 3, 1, {{0, 3}}},
        {"coarse pixels", 0, 64, 4, {{0, 32}, {32, 64}}},
    }));
    DYNAMIC_SECTION(c.name) {
        CheckPolicy policy(1, 3);
        tiles::RenderTile band = tile_of_rows(5, c.y1);
        band.y0 = c.y0;
        band.step = c.step;
        std::set<std::pair<int, int>> chosen;
        for (int i = 0; i < 200; ++i) {
            const tiles::RenderTile rows = policy.choose_rows(band);
            CHECK(rows.index == 5);
            chosen.emplace(rows.y0, rows.y1);
        }
        CHECK(chosen == c.rows);
    }
}
