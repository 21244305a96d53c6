#include "voxelserver/data/water/river.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "voxelserver/data/water/water_cells.hpp"

namespace terravox::water {
namespace {

constexpr double kReturnNoise_m = 0.06;   // standard deviation of a median of one return
constexpr double kSectionNoise_m = 0.02;  // noise that more returns do not reduce
constexpr double kMaxReturns = 100;
// Change of level between adjacent sections that is not penalised.
constexpr double kMinStep_m = 0.02;
constexpr double kStartStep_m = 0.05;
// Share of the fall at a section that comes from farther sections: averages over some eight.
constexpr double kFarther = 0.875;
constexpr int kReweightings = 4;
constexpr double kStray = 2;  // residuals beyond this many deviations lose weight
constexpr double kRim_m = 0.3;
constexpr double kFlatFall_m = 0.12;  // maximum fall of a stretch that gets one level

double certainty(const SectionSample& s) {
    return s.weight > 0 ? 1 / (kReturnNoise_m * kReturnNoise_m / std::min(s.weight, kMaxReturns) +
                               kSectionNoise_m * kSectionNoise_m)
                        : 0;
}

// Minimises the sum of (level - measured)^2 * weight + (level - parent's level)^2 / step^2: exact
// on a forest, in one pass from the leaves and one back. step_m: from each section to its parent
std::vector<double> solve(const Drainage& d, const std::vector<SectionSample>& samples,
                          const std::vector<double>& weight, const std::vector<double>& step_m) {
    std::vector<double> pull = weight;
    std::vector<double> sum(weight.size());
    std::vector<double> level(weight.size());
    for (std::size_t i = 0; i < sum.size(); ++i)
        sum[i] = weight[i] * samples[i].level_m;
    const auto stiff = [&](std::int32_t s) {
        return 1 / (step_m[to_index(s)] * step_m[to_index(s)]);
    };
    for (std::size_t k = d.order.size(); k-- > 0;) {
        const std::int32_t s = d.order[k];
        const std::int32_t p = d.parent[to_index(s)];
        if (p == Adjacency::kNone || !(pull[to_index(s)] > 0))
            continue;
        const double share = stiff(s) / (pull[to_index(s)] + stiff(s));
        pull[to_index(p)] += pull[to_index(s)] * share;
        sum[to_index(p)] += sum[to_index(s)] * share;
    }
    for (const std::int32_t s : d.order) {
        const std::int32_t p = d.parent[to_index(s)];
        if (p == Adjacency::kNone)
            level[to_index(s)] = pull[to_index(s)] > 0 ? sum[to_index(s)] / pull[to_index(s)] : 0;
        else
            level[to_index(s)] =
                (sum[to_index(s)] + stiff(s) * level[to_index(p)]) / (pull[to_index(s)] + stiff(s));
    }
    return level;
}

// The typical change of level from a section to its parent in its neighbourhood: the net change
// over a stretch towards the outlet or away from it, whichever is larger. One body may contain a
// river that hardly falls and a steep brook that flows into it: smoothed with the river's step, the
// whole brook would be treated as outliers. Net, because an outlier goes up and down again.
std::vector<double> local_steps(const Drainage& d, const std::vector<double>& level) {
    const std::size_t count = level.size();
    std::vector<double> change(count), towards(count), away(count), from_above(count),
        branches(count);
    for (const std::int32_t s : d.order) {
        const std::int32_t p = d.parent[to_index(s)];
        if (p == Adjacency::kNone)
            continue;
        change[to_index(s)] = towards[to_index(s)] = level[to_index(s)] - level[to_index(p)];
        if (d.parent[to_index(p)] != Adjacency::kNone)
            towards[to_index(s)] += kFarther * (towards[to_index(p)] - change[to_index(s)]);
    }
    for (std::size_t k = count; k-- > 0;) {
        const std::int32_t s = d.order[k];
        const std::int32_t p = d.parent[to_index(s)];
        away[to_index(s)] = change[to_index(s)];
        if (branches[to_index(s)] > 0)
            away[to_index(s)] +=
                kFarther * (from_above[to_index(s)] / branches[to_index(s)] - change[to_index(s)]);
        if (p != Adjacency::kNone) {
            from_above[to_index(p)] += away[to_index(s)];
            branches[to_index(p)] += 1;
        }
    }
    for (std::size_t i = 0; i < count; ++i)
        change[i] = std::max({kMinStep_m, std::abs(towards[i]), std::abs(away[i])});
    return change;
}

std::vector<double> smooth(const Drainage& d, const std::vector<SectionSample>& samples) {
    std::vector<double> base(samples.size());
    for (std::size_t i = 0; i < base.size(); ++i)
        base[i] = certainty(samples[i]);
    std::vector<double> weight = base;
    std::vector<double> level =
        solve(d, samples, weight, std::vector<double>(samples.size(), kStartStep_m));
    for (int round = 0; round < kReweightings; ++round) {
        const std::vector<double> step = local_steps(d, level);
        for (std::size_t i = 0; i < base.size(); ++i) {
            // A section may also deviate from its neighbours by the size of a step.
            const double deviation2 = base[i] > 0 ? 1 / base[i] + step[i] * step[i] : 1;
            const double residual = samples[i].level_m - level[i];
            weight[i] = base[i] / (1 + residual * residual / (kStray * kStray * deviation2));
        }
        level = solve(d, samples, weight, step);
    }
    return level;
}

// Stretches of the drainage tree, which are merged in order of slope, the flattest first.
class Stretches {
public:
    Stretches(const RiverSections& sections, const Drainage& d, const std::vector<double>& level)
        : m_sections(sections),
          m_d(d),
          m_root(level.size()),
          m_low(level),
          m_high(level),
          m_mean(level),
          m_first(sections.along_m),
          m_last(sections.along_m),
          m_cells(level.size()) {
        std::iota(m_root.begin(), m_root.end(), 0);
        for (std::size_t i = 0; i < level.size(); ++i)
            m_cells[i] = sections.cells[i];
    }

    // Joins neighbours whose means differ by no more than `step_m` and `slope` over the shorter
    // one.
    void join(double step_m, double slope) {
        for (const std::int32_t s : m_d.order) {
            if (m_d.parent[to_index(s)] == Adjacency::kNone)
                continue;
            const std::int32_t a = root(s);
            const std::int32_t b = root(m_d.parent[to_index(s)]);
            if (a == b)
                continue;
            const double rise = std::abs(m_mean[to_index(a)] - m_mean[to_index(b)]);
            if (rise > step_m + slope * std::min(length(a), length(b)))
                continue;
            if (std::max(m_high[to_index(a)], m_high[to_index(b)]) -
                    std::min(m_low[to_index(a)], m_low[to_index(b)]) <=
                kFlatFall_m)
                unite(a, b);
        }
    }

    [[nodiscard]] double level(std::int32_t s) { return m_mean[to_index(root(s))]; }

private:
    std::int32_t root(std::int32_t s) {
        while (m_root[to_index(s)] != s)
            s = m_root[to_index(s)] = m_root[to_index(m_root[to_index(s)])];
        return s;
    }
    [[nodiscard]] double length(std::int32_t r) const {
        return m_last[to_index(r)] - m_first[to_index(r)] + m_sections.length_m;
    }
    void unite(std::int32_t a, std::int32_t b) {
        if (m_cells[to_index(a)] > m_cells[to_index(b)])
            std::swap(a, b);
        m_mean[to_index(b)] = (m_mean[to_index(a)] * m_cells[to_index(a)] +
                               m_mean[to_index(b)] * m_cells[to_index(b)]) /
                              (m_cells[to_index(a)] + m_cells[to_index(b)]);
        m_cells[to_index(b)] += m_cells[to_index(a)];
        m_low[to_index(b)] = std::min(m_low[to_index(a)], m_low[to_index(b)]);
        m_high[to_index(b)] = std::max(m_high[to_index(a)], m_high[to_index(b)]);
        m_first[to_index(b)] = std::min(m_first[to_index(a)], m_first[to_index(b)]);
        m_last[to_index(b)] = std::max(m_last[to_index(a)], m_last[to_index(b)]);
        m_root[to_index(a)] = b;
    }

    const RiverSections& m_sections;
    const Drainage& m_d;
    std::vector<std::int32_t> m_root;
    std::vector<double> m_low;
    std::vector<double> m_high;
    std::vector<double> m_mean;
    std::vector<double> m_first;
    std::vector<double> m_last;
    std::vector<double> m_cells;
};

std::vector<double> flatten(const RiverSections& sections, const Drainage& d,
                            const std::vector<double>& level) {
    struct Pass {
        double step_m;
        double slope;
    };
    constexpr Pass kPasses[] = {{0, 0},         {0, 0.0001},    {0.005, 0.0003},
                                {0.01, 0.0006}, {0.015, 0.001}, {0.02, 0.002}};
    Stretches stretches(sections, d, level);
    for (const Pass& pass : kPasses)
        stretches.join(pass.step_m, pass.slope);
    std::vector<double> out(level.size());
    for (std::int32_t s = 0; s < sections.size(); ++s)
        out[to_index(s)] = stretches.level(s);
    return out;
}

}  // namespace

std::vector<double> river_profile(const RiverSections& sections,
                                  const std::vector<SectionSample>& samples) {
    const std::vector<double> first = smooth(breadth_first(sections, 0), samples);
    const Drainage d = drain(sections, first, kRim_m);
    const std::vector<double> smoothed = smooth(d, samples);
    std::vector<double> weight(samples.size());
    for (std::size_t i = 0; i < weight.size(); ++i)
        weight[i] = certainty(samples[i]) + 1;
    std::vector<double> level = between_envelopes(sections, d, isotonic(d, smoothed, weight));
    level = flatten(sections, d, level);
    raise_to_lower(sections, d, level);
    return level;
}

}  // namespace terravox::water
