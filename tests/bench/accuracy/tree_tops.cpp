#include "tests/bench/accuracy/tree_tops.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <unordered_map>

namespace terravox::bench {
namespace {

constexpr double kCellSize_m =
    8;  ///< of the grid in which partners are sought; no partner is farther away

std::vector<float> smoothed(const Area& area, const std::vector<float>& canopy_m) {
    constexpr std::array<float, 3> kWeights = {1, 2, 1};
    std::vector<float> out(canopy_m.size());
    for (int row = 0; row < area.height; ++row)
        for (int column = 0; column < area.width; ++column) {
            float sum = 0;
            float weight = 0;
            for (int dr = -1; dr <= 1; ++dr)
                for (int dc = -1; dc <= 1; ++dc) {
                    if (!area.holds(column + dc, row + dr))
                        continue;
                    const float w = kWeights[static_cast<std::size_t>(dc + 1)] *
                                    kWeights[static_cast<std::size_t>(dr + 1)];
                    sum += w * canopy_m[area.index(column + dc, row + dr)];
                    weight += w;
                }
            out[area.index(column, row)] = canopy_m[area.index(column, row)] > 0 ? sum / weight : 0;
        }
    return out;
}

bool highest_within(const Area& area, const std::vector<float>& heights,
                    const std::vector<float>& around, int column, int row, double radius_m) {
    const std::pair here{heights[area.index(column, row)], around[area.index(column, row)]};
    const int reach = static_cast<int>(radius_m);
    for (int dr = -reach; dr <= reach; ++dr)
        for (int dc = -reach; dc <= reach; ++dc) {
            if (dc * dc + dr * dr > radius_m * radius_m || !area.holds(column + dc, row + dr))
                continue;
            const std::pair there{heights[area.index(column + dc, row + dr)],
                                  around[area.index(column + dc, row + dr)]};
            const bool before = dr < 0 || (dr == 0 && dc < 0);
            if (there > here || (there == here && before))
                return false;
        }
    return true;
}

std::int64_t cell_of(double east_m, double south_m, int dx = 0, int dy = 0) {
    const auto part = [](double v) {
        return static_cast<std::int64_t>(std::floor(v / kCellSize_m));
    };
    return (part(south_m) + dy) * 1'000'003 + part(east_m) + dx;
}

}  // namespace

CrownWidth fit_crown_width(const std::vector<TreeTop>& trees) {
    double n = 0;
    double x = 0;
    double y = 0;
    double xx = 0;
    double xy = 0;
    for (const TreeTop& tree : trees) {
        const double square = tree.height_m * tree.height_m;
        const double width = 2 * tree.radius_m;
        n += 1;
        x += square;
        y += width;
        xx += square * square;
        xy += square * width;
    }
    const double spread = n * xx - x * x;
    if (n == 0)
        return {};
    if (spread <= 1e-9 * n * xx)
        return {y / n, 0, 0};
    const double slope = (n * xy - x * y) / spread;
    CrownWidth out{(y - slope * x) / n, slope};
    double squares = 0;
    for (const TreeTop& tree : trees)
        squares += std::pow(2 * tree.radius_m - out.width_m(tree.height_m), 2);
    out.spread_m = std::sqrt(squares / n);
    return out;
}

std::vector<TreeTop> find_tree_tops(const Area& area, const std::vector<float>& canopy_m,
                                    const CrownWidth& width, double min_m) {
    const std::vector<float> around = smoothed(area, canopy_m);
    std::vector<TreeTop> out;
    for (int row = 0; row < area.height; ++row)
        for (int column = 0; column < area.width; ++column) {
            const double top = canopy_m[area.index(column, row)];
            if (top < min_m ||
                !highest_within(area, canopy_m, around, column, row, 0.5 * width.window_m(top)))
                continue;
            out.push_back({column + 0.5, row + 0.5, top, 0});
        }
    return out;
}

double TreeMatch::precision() const noexcept {
    return static_cast<double>(pairs.size()) /
           static_cast<double>(std::max<std::size_t>(1, pairs.size() + false_positives));
}
double TreeMatch::recall() const noexcept {
    return static_cast<double>(pairs.size()) /
           static_cast<double>(std::max<std::size_t>(1, pairs.size() + missed));
}
double TreeMatch::f1() const noexcept {
    return 2.0 * static_cast<double>(pairs.size()) /
           static_cast<double>(
               std::max<std::size_t>(1, 2 * pairs.size() + missed + false_positives));
}

TreeMatch match_trees(const std::vector<TreeTop>& found, const std::vector<TreeTop>& real,
                      double min_m) {
    std::unordered_map<std::int64_t, std::vector<std::size_t>> cells;
    for (std::size_t i = 0; i < found.size(); ++i)
        cells[cell_of(found[i].east_m, found[i].south_m)].push_back(i);
    struct Candidate {
        double distance_m;
        std::size_t found;
        std::size_t real;
    };
    std::vector<Candidate> candidates;
    for (std::size_t k = 0; k < real.size(); ++k)
        for (int dy = -1; dy <= 1; ++dy)
            for (int dx = -1; dx <= 1; ++dx) {
                const auto cell = cells.find(cell_of(real[k].east_m, real[k].south_m, dx, dy));
                if (cell == cells.end())
                    continue;
                for (const std::size_t i : cell->second) {
                    const double away = std::hypot(found[i].east_m - real[k].east_m,
                                                   found[i].south_m - real[k].south_m);
                    if (away <= std::min(kCellSize_m, 0.6 * real[k].radius_m + 1.0))
                        candidates.push_back({away, i, k});
                }
            }
    std::sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
        return a.distance_m != b.distance_m ? a.distance_m < b.distance_m
               : a.found != b.found         ? a.found < b.found
                                            : a.real < b.real;
    });
    std::vector<char> used_found(found.size()), used_real(real.size());
    TreeMatch out;
    for (const Candidate& c : candidates) {
        if (used_found[c.found] != 0 || used_real[c.real] != 0)
            continue;
        used_found[c.found] = used_real[c.real] = 1;
        if (real[c.real].height_m >= min_m)
            out.pairs.push_back({c.found, c.real});
    }
    for (std::size_t k = 0; k < real.size(); ++k)
        out.missed += used_real[k] == 0 && real[k].height_m >= min_m ? 1U : 0U;
    out.false_positives =
        static_cast<std::size_t>(std::count(used_found.begin(), used_found.end(), 0));
    return out;
}

}  // namespace terravox::bench
