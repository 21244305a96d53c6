#include "tests/bench/accuracy/tree_tops.hpp"

#include <cmath>
#include <random>

#include "tests/catch.hpp"

using namespace terravox::bench;

TEST_CASE("trees are paired one to one, nearest first; low ones may be met but need not be",
          "[bench][accuracy][trees]") {
    const std::vector<TreeTop> real = {
        {10, 10, 12, 3}, {12, 10, 12, 3}, {40, 40, 2, 1}, {60, 60, 12, 3}};
    const std::vector<TreeTop> found = {{10.5, 10, 12, 0}, {40, 40.5, 3.2, 0}, {20, 70, 9, 0}};
    const TreeMatch match = match_trees(found, real, 3);
    REQUIRE(match.pairs.size() == 1);
    CHECK(match.pairs[0].found == 0);
    CHECK(match.pairs[0].real == 0);
    CHECK(match.missed == 2);  // the neighbour and the one that was not found; not the bush
    CHECK(match.false_positives == 1);  // not the one on the bush
    CHECK(match.precision() == Approx(0.5));
    CHECK(match.recall() == Approx(1.0 / 3));
}

TEST_CASE("pairs never share a tree and never lie too far apart", "[bench][accuracy][trees]") {
    const auto seed = GENERATE(range(0U, 20U));
    CAPTURE(seed);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> place(0, 60), height(2, 30), radius(1, 5);
    std::vector<TreeTop> real(60), found(50);
    for (TreeTop& t : real)
        t = {place(random), place(random), height(random), radius(random)};
    for (TreeTop& t : found)
        t = {place(random), place(random), height(random), 0};
    const TreeMatch match = match_trees(found, real, 3);
    std::vector<int> used_found(found.size()), used_real(real.size());
    for (const auto& pair : match.pairs) {
        CHECK(++used_found[pair.found] == 1);
        CHECK(++used_real[pair.real] == 1);
        CHECK(std::hypot(found[pair.found].east_m - real[pair.real].east_m,
                         found[pair.found].south_m - real[pair.real].south_m) <=
              0.6 * real[pair.real].radius_m + 1.0);
    }
}
