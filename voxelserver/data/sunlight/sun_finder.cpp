#include "voxelserver/data/sunlight/sun.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <vector>

#include "common/util/det_math.hpp"

namespace terravox::sunlight {
namespace {

constexpr double kTile_m = 12;
constexpr std::size_t kMinCells = 500;
/// Share of the light that comes from the sky, for the search; the true one is found later.
constexpr float kSky = 0.3F;

/// The natural logarithm of [0.3, 1.7], to 0.0012: the search evaluates some million. The series of
/// the inverse hyperbolic tangent.
float to_log_light(float light) noexcept {
    const float z = (light - 1) / (light + 1);
    const float square = z * z;
    return 2 * z * (1 + square * (1.0F / 3 + square * (1.0F / 5 + square * (1.0F / 7))));
}

/// One scene, prepared for comparing it with the light of many suns. Its cells are arranged by
/// groups: of one kind in one tile.
class Compared {
public:
    explicit Compared(const Scene& scene) : m_scene(scene) {
        const std::vector<Slope> slopes = measure_slopes(scene);
        for (const std::vector<std::size_t>& group : make_groups(scene))
            add_group(group, slopes);
    }

    [[nodiscard]] std::size_t count() const noexcept { return m_count; }
    [[nodiscard]] double variance() const noexcept { return m_variance; }
    [[nodiscard]] const Scene& scene() const noexcept { return m_scene; }

    /// The horizons of the cells that are compared, towards an azimuth, for compare().
    [[nodiscard]] std::vector<float> horizons_at(double azimuth_deg) const {
        const std::vector<float> all = horizons(m_scene, azimuth_deg);
        std::vector<float> out(m_cells.index.size());
        for (std::size_t i = 0; i < out.size(); ++i)
            out[i] = all[m_cells.index[i]];
        return out;
    }

    /// The sums of a correlation over all cells.
    struct Sums {
        double product = 0;
        double variance = 0;
    };
    [[nodiscard]] Sums compare(const Sun& sun, const std::vector<float>& horizon) const {
        const std::vector<float> light = light_from(sun, horizon);
        Sums out;
        for (const Group& group : m_groups) {
            // Lane by lane: a sum of one after the other waits for each addition.
            std::array<float, kLanes> product{};
            std::array<float, kLanes> square{};
            std::array<float, kLanes> sum{};
            for (std::size_t first = group.begin; first < group.end; first += kLanes)
                for (std::size_t lane = 0; lane < kLanes; ++lane) {
                    const float value = light[first + lane];
                    product[lane] += m_cells.brightness[first + lane] * value;
                    square[lane] += value * value;
                    sum[lane] += value;
                }
            const double group_sum = total(sum);
            out.product += total(product);
            out.variance += total(square) - group_sum * group_sum / group.count;
        }
        return out;
    }

private:
    static constexpr std::size_t kLanes = 4;

    /// A whole number of lanes: what is too many has no weight.
    struct Group {
        std::size_t begin;
        std::size_t end;
        double count;
    };
    struct Cells {
        std::vector<std::size_t> index;  ///< in the scene
        std::vector<float> brightness;   ///< logarithm, relative to the group's mean
        std::vector<float> weight;       ///< 1, or 0
        std::vector<float> east;         ///< slope
        std::vector<float> south;
        std::vector<float> up;  ///< of the normal
    };

    /// The logarithm of the light that each cell would receive.
    [[nodiscard]] std::vector<float> light_from(const Sun& sun,
                                                const std::vector<float>& horizon) const {
        const Sunlit sunlit(sun.altitude_deg);
        const Facing facing(sun);
        std::vector<float> out(horizon.size());
        // Two loops: the compiler takes several cells at once in each, and not in both together.
        for (std::size_t i = 0; i < out.size(); ++i)
            out[i] = std::min(sunlit.share(horizon[i]) *
                                  facing.on(m_cells.east[i], m_cells.south[i], m_cells.up[i]),
                              2.0F);
        for (std::size_t i = 0; i < out.size(); ++i)
            out[i] = m_cells.weight[i] * to_log_light(kSky + (1 - kSky) * out[i]);
        return out;
    }

    static double total(const std::array<float, kLanes>& lanes) noexcept {
        double out = 0;
        for (const float lane : lanes)
            out += static_cast<double>(lane);
        return out;
    }

    /// Cells of one kind in one tile, where these are enough.
    static std::vector<std::vector<std::size_t>> make_groups(const Scene& scene) {
        const int tile = std::max(4, static_cast<int>(std::lround(kTile_m / scene.cell_m)));
        const int across = (scene.width + tile - 1) / tile;
        const int down = (scene.height + tile - 1) / tile;
        std::vector<std::vector<std::size_t>> out(static_cast<std::size_t>(across) *
                                                  static_cast<std::size_t>(down) * kKinds);
        for (int z = scene.margin; z < scene.height - scene.margin; ++z)
            for (int x = scene.margin; x < scene.width - scene.margin; ++x) {
                const std::size_t i = scene.index(x, z);
                const Kind kind = scene.kind[i];
                if (scene.shown[i] == 0 || kind == Kind::kUnknown || kind == Kind::kWater)
                    continue;
                const auto at = static_cast<std::size_t>((z / tile) * across + x / tile);
                out[at * kKinds + static_cast<std::size_t>(kind)].push_back(i);
            }
        std::erase_if(out, [](const std::vector<std::size_t>& group) {
            constexpr std::size_t kMin = 8;
            return group.size() < kMin;
        });
        return out;
    }

    void add_group(const std::vector<std::size_t>& group, const std::vector<Slope>& slopes) {
        const std::vector<double> brightness = measure_brightness(group);
        const std::size_t begin = m_cells.index.size();
        const std::size_t padded = (group.size() + kLanes - 1) / kLanes * kLanes;
        for (std::size_t k = 0; k < padded; ++k) {
            const bool real = k < group.size();
            const std::size_t i = group[real ? k : 0];
            m_cells.index.push_back(i);
            m_cells.brightness.push_back(real ? static_cast<float>(brightness[k]) : 0.0F);
            m_cells.weight.push_back(real ? 1.0F : 0.0F);
            m_cells.east.push_back(slopes[i].east);
            m_cells.south.push_back(slopes[i].south);
            m_cells.up.push_back(slopes[i].up());
        }
        for (const double value : brightness)
            m_variance += value * value;
        m_count += group.size();
        m_groups.push_back({begin, begin + padded, static_cast<double>(group.size())});
    }

    [[nodiscard]] std::vector<double> measure_brightness(
        const std::vector<std::size_t>& group) const {
        constexpr double kDarkest = 0.004;
        constexpr double kOutlier = 1.2;
        std::vector<double> out;
        for (const std::size_t i : group)
            out.push_back(det::log(static_cast<double>(luminance(m_scene.photo[i])) + kDarkest));
        centre(out);
        for (double& value : out)
            value = std::clamp(value, -kOutlier, kOutlier);
        centre(out);
        return out;
    }

    static void centre(std::vector<double>& values) {
        const double mean =
            std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
        for (double& value : values)
            value -= mean;
    }

    const Scene& m_scene;
    Cells m_cells;
    std::vector<Group> m_groups;
    std::size_t m_count = 0;
    double m_variance = 0;
};

struct Trial {
    Sun sun;
    double correlation = -1;
};

class Search {
public:
    explicit Search(std::span<const Scene> scenes) {
        for (const Scene& scene : scenes)
            m_parts.emplace_back(scene);
    }

    [[nodiscard]] std::size_t count() const noexcept {
        std::size_t out = 0;
        for (const Compared& part : m_parts)
            out += part.count();
        return out;
    }

    /// Tries all altitudes at one azimuth.
    void at_azimuth(double azimuth_deg, std::span<const double> altitudes_deg,
                    std::vector<Trial>& out) const {
        std::vector<Compared::Sums> sums(altitudes_deg.size());
        double variance = 0;
        for (const Compared& part : m_parts) {
            const std::vector<float> horizon = part.horizons_at(azimuth_deg);
            variance += part.variance();
            for (std::size_t i = 0; i < sums.size(); ++i) {
                const auto more = part.compare({azimuth_deg, altitudes_deg[i]}, horizon);
                sums[i].product += more.product;
                sums[i].variance += more.variance;
            }
        }
        const double turns = std::floor(azimuth_deg / 360);
        for (std::size_t i = 0; i < sums.size(); ++i) {
            const double scale = std::sqrt(sums[i].variance * variance);
            out.push_back({{azimuth_deg - 360 * turns, altitudes_deg[i]},
                           scale > 0 ? sums[i].product / scale : 0.0});
        }
    }

    /// Tries suns around one, `steps` to each side.
    [[nodiscard]] std::vector<Trial> around(const Sun& sun, int azimuth_steps, double azimuth_deg,
                                            int altitude_steps, double altitude_deg) const {
        std::vector<double> altitudes;
        for (int i = -altitude_steps; i <= altitude_steps; ++i)
            altitudes.push_back(std::clamp(sun.altitude_deg + i * altitude_deg, 8.0, 82.0));
        std::vector<Trial> out;
        for (int i = -azimuth_steps; i <= azimuth_steps; ++i)
            at_azimuth(sun.azimuth_deg + i * azimuth_deg, altitudes, out);
        return out;
    }

private:
    std::vector<Compared> m_parts;
};

const Trial& choose_best(const std::vector<Trial>& trials) {
    return *std::max_element(trials.begin(), trials.end(), [](const Trial& a, const Trial& b) {
        return a.correlation < b.correlation;
    });
}

/// The middle of the trials that are nearly as good as the best: shadows in cells hardly change
/// with small turns.
/// @param centre of the trials
Trial find_middle(const Sun& centre, const std::vector<Trial>& trials) {
    constexpr double kNearly = 0.997;
    const double best = choose_best(trials).correlation;
    const double least = std::min(kNearly * best, best);  // also of a best one below 0
    double turn_sum = 0;
    double altitude_sum = 0;
    double count = 0;
    for (const Trial& trial : trials) {
        if (trial.correlation < least)
            continue;
        const double turn = trial.sun.azimuth_deg - centre.azimuth_deg;
        turn_sum += turn - 360 * std::floor(turn / 360 + 0.5);
        altitude_sum += trial.sun.altitude_deg;
        ++count;
    }
    const double azimuth = centre.azimuth_deg + turn_sum / count;
    return {{azimuth - 360 * std::floor(azimuth / 360), altitude_sum / count}, best};
}

bool is_elsewhere(const Sun& a, const Sun& b) noexcept {
    constexpr double kElsewhere_deg = 25;
    const double turn = std::abs(a.azimuth_deg - b.azimuth_deg);
    return std::min(turn, 360 - turn) >= kElsewhere_deg ||
           std::abs(a.altitude_deg - b.altitude_deg) >= kElsewhere_deg;
}

}  // namespace

std::optional<SunEstimate> find_sun(std::span<const Scene> scenes) {
    const Search fine(scenes);
    if (fine.count() < kMinCells)
        return std::nullopt;
    std::vector<Scene> halves;
    for (const Scene& scene : scenes)
        halves.push_back(halved(scene));
    const Search coarse(halves);

    constexpr std::array kAltitudes_deg{12.0, 18.0, 24.0, 31.0, 38.0, 46.0, 55.0, 65.0, 75.0};
    constexpr double kAzimuthStep_deg = 10;
    std::vector<Trial> trials;
    for (double azimuth = 0; azimuth < 360; azimuth += kAzimuthStep_deg)
        coarse.at_azimuth(azimuth, kAltitudes_deg, trials);
    const Trial first = choose_best(trials);
    double elsewhere = 0;
    for (const Trial& trial : trials)
        if (is_elsewhere(trial.sun, first.sun))
            elsewhere = std::max(elsewhere, trial.correlation);

    Trial best = choose_best(coarse.around(first.sun, 3, 4, 4, 2.5));
    best = choose_best(fine.around(best.sun, 2, 2, 3, 2));
    best = find_middle(best.sun, fine.around(best.sun, 5, 0.5, 4, 0.5));
    SunEstimate out{best.sun, best.correlation, 0};
    if (first.correlation > 0)
        out.margin = std::clamp(1 - elsewhere / first.correlation, 0.0, 1.0);
    return out;
}

bool is_certain(const SunEstimate& estimate) noexcept {
    constexpr double kMinCorrelation = 0.18;
    constexpr double kMinMargin = 0.15;
    // With a high sun, shadows are short, and those of other suns resemble them.
    constexpr double kStrong = 0.4;
    constexpr double kMinMarginOfStrong = 0.04;
    return estimate.correlation >= kMinCorrelation &&
           estimate.margin >= (estimate.correlation >= kStrong ? kMinMarginOfStrong : kMinMargin);
}

}  // namespace terravox::sunlight
