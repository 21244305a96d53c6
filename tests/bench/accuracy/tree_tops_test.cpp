#include "tests/bench/accuracy/tree_tops.hpp"

#include <cmath>
#include <random>

#include "tests/catch.hpp"

using namespace terravox::bench;

namespace {

constexpr Area kArea{0, 0, 80, 80};

/// Cones on a flat floor.
std::vector<float> canopy_of(const std::vector<TreeTop>& trees, bool in_voxels = false) {
    std::vector<float> out(kArea.size());
    for (int row = 0; row < kArea.height; ++row)
        for (int column = 0; column < kArea.width; ++column)
            for (const TreeTop& tree : trees) {
                const double away =
                    std::hypot(column + 0.5 - tree.east_m, row + 0.5 - tree.south_m);
                if (away > tree.radius_m)
                    continue;
                const double height = tree.height_m * (1 - 0.6 * away / tree.radius_m);
                auto& there = out[kArea.index(column, row)];
                there = std::max(there,
                                 static_cast<float>(in_voxels ? std::floor(height) + 0.5 : height));
            }
    return out;
}

}  // namespace

TEST_CASE("trees that stand apart are all found, of any size, in exact heights and in voxels",
          "[bench][accuracy][trees]") {
    const bool in_voxels = GENERATE(false, true);
    CAPTURE(in_voxels);
    const std::vector<TreeTop> trees = {{10.3, 12.8, 6, 2},
                                        {30.5, 10.2, 25, 4.5},
                                        {50.9, 50.1, 12, 3},
                                        {70.2, 20.6, 18, 3.5},
                                        {20.4, 60.7, 30, 5}};
    const auto found =
        find_tree_tops(kArea, canopy_of(trees, in_voxels), fit_crown_width(trees), 3);
    const TreeMatch match = match_trees(found, trees, 3);
    CHECK(match.pairs.size() == trees.size());
    CHECK(match.missed == 0);
    CHECK(match.false_positives == 0);
    CHECK(match.f1() == 1.0);
    for (const auto& pair : match.pairs)
        CHECK(found[pair.found].height_m == Approx(trees[pair.real].height_m).margin(3.2));
}

TEST_CASE("a flat canopy of voxels has one top, not one for each column",
          "[bench][accuracy][trees]") {
    const std::vector<TreeTop> tree = {{40.5, 40.5, 10, 3}};
    std::vector<float> canopy(kArea.size());
    for (int row = 38; row <= 42; ++row)
        for (int column = 38; column <= 42; ++column)
            canopy[kArea.index(column, row)] = 9.5F;
    const auto found = find_tree_tops(kArea, canopy, {4, 0, 0}, 3);
    REQUIRE(found.size() == 1);
    CHECK(found[0].east_m == Approx(40.5).margin(1.01));
    CHECK(found[0].south_m == Approx(40.5).margin(1.01));
}

TEST_CASE("the fit gives back the crowns it was made from", "[bench][accuracy][trees]") {
    std::vector<TreeTop> trees;
    for (double h = 4; h < 30; h += 2)
        trees.push_back({0, 0, h, 0.5 * (2.5 + 0.009 * h * h)});
    const CrownWidth fit = fit_crown_width(trees);
    CHECK(fit.at_ground_m == Approx(2.5));
    CHECK(fit.by_square_per_m == Approx(0.009));
    CHECK(fit.spread_m == Approx(0).margin(1e-9));
    CHECK(fit.window_m(10) == Approx(fit.width_m(10)));
    CHECK(fit_crown_width({}).window_m(20) == Approx(2));
    CHECK(fit_crown_width({{0, 0, 10, 3}, {0, 0, 10, 4}}).width_m(10) == Approx(7));
}

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
