#pragma once

#include <algorithm>
#include <vector>

#include "tests/bench/accuracy/area.hpp"

namespace terravox::bench {

/// A tree as a detector finds it or as the truth has it; metres east and south of the area's
/// north-west corner.
struct TreeTop {
    double east_m = 0;
    double south_m = 0;
    double height_m = 0;  ///< above the ground
    double radius_m = 0;  ///< of the crown; not set by the detector
};

/// Crown width over tree height, width = at_ground + by_square * height^2, fitted to known trees:
/// what the window's size follows. Ref: Popescu & Wynne, "Seeing the Trees in the Forest: Using
/// Lidar and Multispectral Data Fusion with Local Filtering and Variable Window Size for Estimating
/// Tree Height", Photogrammetric Engineering & Remote Sensing 70(5), 2004.
struct CrownWidth {
    double at_ground_m = 2;
    double by_square_per_m = 0;
    double spread_m = 0;  ///< standard deviation of the trees from the fit
    [[nodiscard]] double width_m(double height_m) const noexcept {
        return at_ground_m + by_square_per_m * height_m * height_m;
    }
    /// Diameter of the window: what 99 % of the crowns exceed, so that few neighbours share one; at
    /// least the four adjacent columns. Ref: Chen, Baldocchi, Gong & Kelly, "Isolating Individual
    /// Trees in a Savanna Woodland Using Small Footprint Lidar Data", Photogrammetric Engineering &
    /// Remote Sensing 72(8), 2006 (lower limit of the prediction interval as window).
    [[nodiscard]] double window_m(double height_m) const noexcept {
        return std::max(2.0, width_m(height_m) - 2.58 * spread_m);
    }
};
/// Least squares. Without trees, or with trees of one height: their mean width, or the default.
[[nodiscard]] CrownWidth fit_crown_width(const std::vector<TreeTop>& trees);

/// Tree tops as local maxima of a canopy height model in a circular window that grows with height.
/// Of equal heights, which voxels have many of, the one with the highest surroundings (3 x 3,
/// binomial) counts, then the north-western one. Not smoothed before: at 1 m that would take away
/// every fourth top of this survey.
/// @param canopy_m height above the ground of each column, 0 without plants @param min_m lower
/// maxima are no trees
[[nodiscard]] std::vector<TreeTop> find_tree_tops(const Area& area,
                                                  const std::vector<float>& canopy_m,
                                                  const CrownWidth& width, double min_m);

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
