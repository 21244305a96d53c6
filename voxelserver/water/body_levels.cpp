#include "voxelserver/water/body_levels.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "voxelserver/water/river_profile.hpp"
#include "voxelserver/water/river_sections.hpp"

namespace terravox::water {
namespace {

constexpr double kLakeSpread_m = 0.3;     // noise of 5 cm spreads 0.13 m; a river that falls less cannot be told from a lake
constexpr std::uint64_t kFewReturns = 10;
constexpr double kLowShore = 0.1;         // banks rise from the water: the low ones stand at it
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

struct Seen {
    std::vector<WeightedLevel> levels;  // ascending
    std::uint64_t returns = 0;
    [[nodiscard]] float at(double part) const {
        const auto target = static_cast<std::uint64_t>(part * static_cast<double>(returns));
        std::uint64_t below = 0;
        for (const WeightedLevel& l : levels)
            if ((below += l.weight) > target) return l.level;
        return levels.back().level;
    }
};

Seen seen_levels(const Body& body) {
    Seen out;
    for (const LevelSample& s : body.samples)
        if (s.weight > 0) out.levels.push_back({s.level, s.weight}), out.returns += s.weight;
    std::sort(out.levels.begin(), out.levels.end());
    return out;
}

float lake_level(const Body& body, const Seen& seen) {
    float level = seen.returns > 0 ? seen.at(0.5) : kNan;
    if (seen.returns < kFewReturns && !body.shore.empty()) {
        std::vector<float> shore = body.shore;
        const float low = quantile(shore, kLowShore);
        if (std::isnan(level) || low < level) level = low;
    }
    return level;
}

// Without equalization: what was seen, and the nearest of it (counted through the water) elsewhere.
std::vector<float> as_seen(const Body& body, const Adjacency& beside) {
    std::vector<float> out(body.places.size(), kNan);
    std::vector<std::int32_t> queue;
    for (std::size_t i = 0; i < out.size(); ++i)
        if (body.samples[i].weight > 0) out[i] = body.samples[i].level, queue.push_back(static_cast<std::int32_t>(i));
    for (std::size_t head = 0; head < queue.size(); ++head)
        for (const std::int32_t n : beside.around(queue[head])) {
            if (n == Adjacency::kNone || !std::isnan(out[static_cast<std::size_t>(n)])) continue;
            out[static_cast<std::size_t>(n)] = out[static_cast<std::size_t>(queue[head])];
            queue.push_back(n);
        }
    return out;
}

std::vector<float> river_levels(const Body& body, const Adjacency& beside, float reference, const LevelOptions& options) {
    const RiverSections sections = make_sections(beside, options.cell_m);
    const std::vector<SectionSample> samples = section_samples(sections, body.samples, reference, options.voxel_m);
    const std::vector<double> profile = river_profile(sections, samples);
    std::vector<float> out(body.places.size());
    for (std::size_t i = 0; i < out.size(); ++i)
        out[i] = static_cast<float>(static_cast<double>(reference) + profile[static_cast<std::size_t>(sections.section_of[i])] / options.voxel_m);
    return out;
}

}  // namespace

float quantile(std::vector<float>& values, double part) {
    const auto i = static_cast<std::ptrdiff_t>(std::min(static_cast<double>(values.size() - 1), part * static_cast<double>(values.size())));
    std::nth_element(values.begin(), values.begin() + i, values.end());
    return values[static_cast<std::size_t>(i)];
}

std::vector<float> body_levels(const Body& body, const LevelOptions& options) { return body_levels(body, Adjacency(body.places), options); }

std::vector<float> body_levels(const Body& body, const Adjacency& beside, const LevelOptions& options) {
    const Seen seen = seen_levels(body);
    if (!options.equalize && seen.returns > 0) return as_seen(body, beside);
    if (seen.returns == 0 || static_cast<double>(seen.at(0.9) - seen.at(0.1)) * options.voxel_m < kLakeSpread_m)
        return std::vector<float>(body.places.size(), lake_level(body, seen));
    return river_levels(body, beside, seen.at(0.5), options);
}

}  // namespace terravox::water
