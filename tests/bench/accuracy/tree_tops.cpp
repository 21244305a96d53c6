#include "tests/bench/accuracy/tree_tops.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <unordered_map>

namespace terravox::bench {
namespace {

constexpr double kCellSize_m =
    8;  ///< of the grid in which partners are sought; no partner is farther away

std::int64_t find_cell(double east_m, double south_m, int dx = 0, int dy = 0) {
    const auto part = [](double v) {
        return static_cast<std::int64_t>(std::floor(v / kCellSize_m));
    };
    return (part(south_m) + dy) * 1'000'003 + part(east_m) + dx;
}

}  // namespace

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
        cells[find_cell(found[i].east_m, found[i].south_m)].push_back(i);
    struct Candidate {
        double distance_m;
        std::size_t found;
        std::size_t real;
    };
    std::vector<Candidate> candidates;
    for (std::size_t k = 0; k < real.size(); ++k)
        for (int dy = -1; dy <= 1; ++dy)
            for (int dx = -1; dx <= 1; ++dx) {
                const auto cell = cells.find(find_cell(real[k].east_m, real[k].south_m, dx, dy));
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
