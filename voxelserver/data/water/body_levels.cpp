#include "voxelserver/data/water/body_levels.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "voxelserver/data/water/river.hpp"

namespace terravox::water {
namespace {

// Noise of 5 cm spreads 0.13 m; a river that falls less is indistinguishable from a lake.
constexpr double kLakeSpread_m = 0.3;
constexpr std::uint64_t kFewReturns = 10;
constexpr double kOff_m = 0.2;  // noise alone does not lift a section's median so far from the lake
constexpr int kOffSections = 3;    // in one stretch: outliers are scattered
constexpr double kLowShore = 0.1;  // banks rise from the water: the low ones are at its level
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

struct Seen {
    std::vector<WeightedLevel> levels;  // ascending
    std::uint64_t returns = 0;
    [[nodiscard]] float at(double part) const {
        const auto target = static_cast<std::uint64_t>(part * static_cast<double>(returns));
        std::uint64_t below = 0;
        for (const WeightedLevel& l : levels)
            if ((below += l.weight) > target)
                return l.level;
        return levels.back().level;
    }
};

Seen seen_levels(const Body& body) {
    Seen out;
    for (const LevelSample& s : body.samples)
        if (s.weight > 0) {
            out.levels.push_back({s.level, s.weight});
            out.returns += s.weight;
        }
    std::sort(out.levels.begin(), out.levels.end());
    return out;
}

float lake_level(const Body& body, const Seen& seen) {
    float level = seen.returns > 0 ? seen.at(0.5) : kNan;
    if (seen.returns < kFewReturns && !body.shore.empty()) {
        std::vector<float> shore = body.shore;
        const float low = quantile(shore, kLowShore);
        if (std::isnan(level) || low < level)
            level = low;
    }
    return level;
}

// Without equalization: the measured levels, and the nearest one (by distance through the water)
// elsewhere.
std::vector<float> as_seen(const Body& body, const Adjacency& adjacency) {
    std::vector<float> out(body.places.size(), kNan);
    std::vector<std::int32_t> queue;
    for (std::size_t i = 0; i < out.size(); ++i)
        if (body.samples[i].weight > 0) {
            out[i] = body.samples[i].level;
            queue.push_back(static_cast<std::int32_t>(i));
        }
    for (std::size_t head = 0; head < queue.size(); ++head)
        for (const std::int32_t n : adjacency.around(queue[head])) {
            if (n == Adjacency::kNone || !std::isnan(out[static_cast<std::size_t>(n)]))
                continue;
            out[static_cast<std::size_t>(n)] = out[static_cast<std::size_t>(queue[head])];
            queue.push_back(n);
        }
    return out;
}

// Whether a stretch of the water is off the level of the rest. A steep brook has few cells compared
// with the lake that it flows into.
bool has_branch(const RiverSections& sections, const std::vector<SectionSample>& samples) {
    const auto off = [&](std::size_t s) {
        return samples[s].weight > 0 && std::abs(samples[s].level_m) > kOff_m;
    };
    std::vector<char> visited(samples.size());
    std::vector<std::int32_t> stack;
    for (std::int32_t start = 0; start < sections.size(); ++start) {
        if (visited[static_cast<std::size_t>(start)] != 0 || !off(static_cast<std::size_t>(start)))
            continue;
        int count = 0;
        stack.assign(1, start);
        visited[static_cast<std::size_t>(start)] = 1;
        while (!stack.empty()) {
            const std::int32_t s = stack.back();
            stack.pop_back();
            if (off(static_cast<std::size_t>(s)) && ++count >= kOffSections)
                return true;
            sections.each_neighbour(s, [&](std::int32_t neighbour) {
                const auto n = static_cast<std::size_t>(neighbour);
                if (visited[n] != 0 || (samples[n].weight > 0 && !off(n)))
                    return;
                visited[n] = 1;
                stack.push_back(neighbour);
            });
        }
    }
    return false;
}

std::vector<float> levels_along(const Body& body, const RiverSections& sections,
                                const std::vector<SectionSample>& samples, float reference,
                                double voxel_m) {
    const std::vector<double> profile = river_profile(sections, samples);
    std::vector<float> out(body.places.size());
    for (std::size_t i = 0; i < out.size(); ++i)
        out[i] =
            static_cast<float>(static_cast<double>(reference) +
                               profile[static_cast<std::size_t>(sections.section_of[i])] / voxel_m);
    return out;
}

}  // namespace

float quantile(std::vector<float>& values, double part) {
    const auto i = static_cast<std::ptrdiff_t>(std::min(static_cast<double>(values.size() - 1),
                                                        part * static_cast<double>(values.size())));
    std::nth_element(values.begin(), values.begin() + i, values.end());
    return values[static_cast<std::size_t>(i)];
}

std::vector<float> body_levels(const Body& body, const LevelOptions& options) {
    return body_levels(body, Adjacency(body.places), options);
}

std::vector<float> body_levels(const Body& body, const Adjacency& adjacency,
                               const LevelOptions& options) {
    const Seen seen = seen_levels(body);
    if (!options.equalize && seen.returns > 0)
        return as_seen(body, adjacency);
    const auto metres = [&](float from, float to) {
        return (static_cast<double>(to) - static_cast<double>(from)) * options.voxel_m;
    };
    const auto lake = [&] {
        return std::vector<float>(body.places.size(), lake_level(body, seen));
    };
    if (seen.returns == 0)
        return lake();
    const float middle = seen.at(0.5);
    const bool level = metres(seen.at(0.1), seen.at(0.9)) < kLakeSpread_m;
    if (level && std::max(metres(seen.levels.front().level, middle),
                          metres(middle, seen.levels.back().level)) <= kOff_m)
        return lake();
    const RiverSections sections = make_sections(adjacency, options.cell_m);
    const std::vector<SectionSample> samples =
        section_samples(sections, body.samples, middle, options.voxel_m);
    if (level && (seen.returns < kFewReturns || !has_branch(sections, samples)))
        return lake();
    return levels_along(body, sections, samples, middle, options.voxel_m);
}

}  // namespace terravox::water
