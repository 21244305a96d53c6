#pragma once

#include <cstddef>
#include <vector>

namespace terravox::bench {

/// A tree as the voxelizer finds it or as the truth has it; metres east and south of the area's
/// north-west corner.
struct TreeTop {
    double east_m = 0;
    double south_m = 0;
    double height_m = 0;  ///< above the ground
    double radius_m = 0;  ///< of the crown; not set by the voxelizer
};

/// Which found tree is which true one.
struct TreeMatch {
    struct Pair {
        std::size_t found;
        std::size_t real;
    };
    std::vector<Pair> pairs;
    std::size_t missed = 0;           ///< true trees of at least the minimum height without a pair
    std::size_t false_positives = 0;  ///< found trees without a pair
    [[nodiscard]] double precision() const noexcept;
    [[nodiscard]] double recall() const noexcept;
    [[nodiscard]] double f1() const noexcept;
};
/// Pairs one to one, nearest first, within 0.6 crown radii + 1 m. True trees below `min_m` may be
/// met (no error) but need not be.
[[nodiscard]] TreeMatch match_trees(const std::vector<TreeTop>& found,
                                    const std::vector<TreeTop>& real, double min_m);

}  // namespace terravox::bench
