#include "voxelserver/sunlight/sun_finder.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "common/util/det_math.hpp"

namespace terravox::sunlight {
namespace {

constexpr double kTile_m = 12;
constexpr std::size_t kMinCells = 500;
/// Share of the light that comes from the sky, for the search; the true one is found later.
constexpr float kSky = 0.3F;

/// One scene, prepared for comparing it with the light of many suns.
class Compared {
public:
    explicit Compared(const Scene& scene) : m_scene(scene), m_slopes(slopes_of(scene)) {
        const int tile = std::max(4, static_cast<int>(std::lround(kTile_m / scene.cell_m)));
        const int across = (scene.width + tile - 1) / tile;
        const int down = (scene.height + tile - 1) / tile;
        m_group_count = static_cast<std::size_t>(across) * static_cast<std::size_t>(down) * kKinds;
        for (int z = scene.margin; z < scene.height - scene.margin; ++z)
            for (int x = scene.margin; x < scene.width - scene.margin; ++x) {
                const std::size_t i = scene.index(x, z);
                const Kind kind = scene.kind[i];
                if (scene.shown[i] == 0 || kind == Kind::kUnknown || kind == Kind::kWater)
                    continue;
                const std::size_t group =
                    (static_cast<std::size_t>(z / tile) * static_cast<std::size_t>(across) +
                     static_cast<std::size_t>(x / tile)) *
                        kKinds +
                    static_cast<std::size_t>(kind);
                m_cells.push_back({i, group, 0});
            }
        drop_small_groups();
        take_brightness();
    }

    [[nodiscard]] std::size_t count() const noexcept { return m_cells.size(); }
    [[nodiscard]] double variance() const noexcept { return m_variance; }
    [[nodiscard]] const Scene& scene() const noexcept { return m_scene; }

    /// The sums of a correlation over all cells.
    struct Sums {
        double product = 0;
        double variance = 0;
    };
    [[nodiscard]] Sums compare(const Sun& sun, const std::vector<float>& horizon) const {
        const Sunlit sunlit(sun.altitude_deg);
        const Facing facing(sun);
        std::vector<double> sum(m_group_count);
        Sums out;
        for (const Cell& cell : m_cells) {
            const float lit = sunlit.share(horizon[cell.index]) * facing.on(m_slopes[cell.index]);
            const double light = log_of(kSky + (1 - kSky) * std::min(lit, 2.0F));
            out.product += cell.brightness * light;
            out.variance += light * light;
            sum[cell.group] += light;
        }
        for (std::size_t g = 0; g < m_group_count; ++g)
            if (m_in_group[g] > 0)
                out.variance -= sum[g] * sum[g] / m_in_group[g];
        return out;
    }

private:
    struct Cell {
        std::size_t index;
        std::size_t group;  ///< of one kind in one tile
        double brightness;  ///< logarithm, relative to the group's mean
    };

    // A table: the search evaluates some million logarithms.
    static double log_of(float light) {
        constexpr int kSteps = 1024;
        static const std::array<double, 2 * kSteps + 1> table = [] {
            std::array<double, 2 * kSteps + 1> made{};
            for (std::size_t i = 0; i < made.size(); ++i)
                made[i] = det::log(std::max(static_cast<double>(i) / kSteps, 1e-3));
            return made;
        }();
        return table[static_cast<std::size_t>(std::min(light, 2.0F) * kSteps)];
    }

    void drop_small_groups() {
        constexpr double kMin = 8;
        std::vector<double> count(m_group_count);
        for (const Cell& cell : m_cells)
            ++count[cell.group];
        std::erase_if(m_cells, [&](const Cell& cell) { return count[cell.group] < kMin; });
        m_in_group.assign(m_group_count, 0);
        for (const Cell& cell : m_cells)
            ++m_in_group[cell.group];
    }

    void centre() {
        std::vector<double> sum(m_group_count);
        for (const Cell& cell : m_cells)
            sum[cell.group] += cell.brightness;
        for (Cell& cell : m_cells)
            cell.brightness -= sum[cell.group] / m_in_group[cell.group];
    }

    void take_brightness() {
        constexpr double kDarkest = 0.004;
        constexpr double kOutlier = 1.2;
        for (Cell& cell : m_cells)
            cell.brightness =
                det::log(static_cast<double>(luminance(m_scene.photo[cell.index])) + kDarkest);
        centre();
        for (Cell& cell : m_cells)
            cell.brightness = std::clamp(cell.brightness, -kOutlier, kOutlier);
        centre();
        for (const Cell& cell : m_cells)
            m_variance += cell.brightness * cell.brightness;
    }

    const Scene& m_scene;
    std::vector<Slope> m_slopes;
    std::vector<Cell> m_cells;
    std::vector<double> m_in_group;
    std::size_t m_group_count = 0;
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
            const std::vector<float> horizon = horizons(part.scene(), azimuth_deg);
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

const Trial& best_of(const std::vector<Trial>& trials) {
    return *std::max_element(trials.begin(), trials.end(), [](const Trial& a, const Trial& b) {
        return a.correlation < b.correlation;
    });
}

/// The middle of the trials that are nearly as good as the best: shadows in cells hardly change
/// with small turns.
/// @param centre of the trials
Trial middle_of(const Sun& centre, const std::vector<Trial>& trials) {
    constexpr double kNearly = 0.997;
    const double best = best_of(trials).correlation;
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
    const Trial first = best_of(trials);
    double elsewhere = 0;
    for (const Trial& trial : trials)
        if (is_elsewhere(trial.sun, first.sun))
            elsewhere = std::max(elsewhere, trial.correlation);

    Trial best = best_of(coarse.around(first.sun, 3, 4, 4, 2.5));
    best = best_of(fine.around(best.sun, 2, 2, 3, 2));
    best = middle_of(best.sun, fine.around(best.sun, 5, 0.5, 4, 0.5));
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
