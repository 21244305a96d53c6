#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

#include "common/util/det_math.hpp"
#include "common/voxel/colour.hpp"
#include "raytracer/analyse/evaluators/cell_evaluator.hpp"
#include "raytracer/core/base/random.hpp"
#include "raytracer/core/base/ray.hpp"

namespace terravox::analyse {
namespace {

/// The generator of a lattice of `count` points: coprime with it, and near its golden section,
/// where the points lie most evenly. Ref: Korobov lattices; for Fibonacci numbers this is the
/// Fibonacci lattice.
int lattice_generator(int count) {
    constexpr double kGolden = 0.6180339887498949;
    const int ideal = static_cast<int>(count * kGolden + 0.5);
    for (int off = 0;; ++off)
        for (const int g : {ideal + off, ideal - off})
            if (g > 0 && g < count + 1 && std::gcd(g, count) == 1)
                return g;
}

/// The square of the shortest distance of two points of a lattice of `count` points on a torus.
double measure_gap2(std::int64_t count, std::int64_t generator) noexcept {
    double out = 1;
    for (std::int64_t i = 1; i < count; ++i) {
        const std::int64_t j = i * generator % count;
        const auto u = static_cast<double>(std::min(i, count - i)) / static_cast<double>(count);
        const auto v = static_cast<double>(std::min(j, count - j)) / static_cast<double>(count);
        out = std::min(out, u * u + v * v);
    }
    return out;
}

/// The generator of a lattice of `sets` times as many points, which is made of shifted copies of
/// this one: that with the widest gaps.
std::int64_t refined_generator(std::int64_t count, std::int64_t generator, std::int64_t sets) {
    std::int64_t best = generator;
    double widest = -1;
    for (std::int64_t j = 0; j < sets; ++j) {
        const std::int64_t refined = generator + count * j;
        if (std::gcd(refined, count * sets) != 1)
            continue;
        const double gap = measure_gap2(count * sets, refined);
        if (gap > widest) {
            widest = gap;
            best = refined;
        }
    }
    return best;
}

double to_fraction(double v) noexcept {
    return v - std::floor(v);
}

/// A direction towards the sky, and its share of each of the three measures.
struct SkyDirection {
    core::Vec3 to;  ///< of unit length, y > 0
    /// r: by the cosine of the zenith angle, g: by solid angle, b: by zenith angle. Over all
    /// directions of a set each adds up to 1.
    voxel::Colour share;
};

/// Sets of directions over the upper half of a sphere, evenly spread over azimuth and zenith angle.
///
/// One set serves three measures: of the sky's zenith angles, uniform ones give openness directly
/// (the mean free angle), and the other two by weights, with less noise at steep walls than
/// directions by solid angle. A set is a lattice of rank 1, shifted. All sets together are one
/// finer lattice, so that neighbouring cells err differently and means over cells converge; there
/// are few, so that many cells of a wave have a set in common, and their rays are traced together.
/// Ref: Yokoyama, Shirasawa, Pike, "Visualizing topography by openness", 2002; Sloan & Joe,
/// "Lattice Methods for Multiple Integration", 1994. Immutable.
class SkyDirections {
public:
    /// @param count directions of a set, at least 2
    explicit SkyDirections(int count) : m_count(static_cast<std::size_t>(count)) {
        m_directions.reserve(kSets * m_count);
        const std::int64_t generator = lattice_generator(count);
        constexpr auto kAllSets = static_cast<std::int64_t>(kSets);
        const std::int64_t refined = refined_generator(count, generator, kAllSets);
        const auto points = static_cast<double>(count * kAllSets);
        for (std::int64_t set = 0; set < kAllSets; ++set) {
            // Half a step of the finer lattice off the zenith and the horizon.
            const double shift_u = (static_cast<double>(set) + 0.5) / points;
            const double shift_v = to_fraction(static_cast<double>(set * refined) / points);
            double sum[3] = {};
            std::vector<std::array<double, 3>> weights;
            weights.reserve(m_count);
            for (std::int64_t i = 0; i < count; ++i) {
                const double u = to_fraction(static_cast<double>(i) / count + shift_u);
                const double v =
                    to_fraction(static_cast<double>(i * generator % count) / count + shift_v);
                const det::SinCos zenith = det::sin_cos(u * det::kPi / 2);
                const det::SinCos azimuth = det::sin_cos(2 * det::kPi * v);
                m_directions.push_back(
                    {{zenith.sin * azimuth.cos, zenith.cos, zenith.sin * azimuth.sin}, {}});
                weights.push_back({zenith.sin * zenith.cos, zenith.sin, 1});
                for (std::size_t m = 0; m < 3; ++m)
                    sum[m] += weights.back()[m];
            }
            for (std::size_t i = 0; i < m_count; ++i)
                m_directions[static_cast<std::size_t>(set) * m_count + i].share = {
                    static_cast<float>(weights[i][0] / sum[0]),
                    static_cast<float>(weights[i][1] / sum[1]),
                    static_cast<float>(weights[i][2] / sum[2])};
        }
    }
    /// The set of a cell, below kSets.
    /// @param cell any number that identifies a cell; the same number gives the same set
    [[nodiscard]] static std::size_t choose_set(std::uint64_t cell) noexcept {
        return core::hash64(cell) % kSets;
    }
    [[nodiscard]] std::span<const SkyDirection> of(std::size_t set) const noexcept {
        return std::span(m_directions).subspan(set * m_count, m_count);
    }
    [[nodiscard]] std::size_t count() const noexcept { return m_count; }

    static constexpr std::size_t kSets = 8;

private:
    std::size_t m_count;
    std::vector<SkyDirection> m_directions;
};

constexpr float kZenithAngle_deg = 90;

double make_range(const shade::View& view) noexcept {
    const double range_m = view.scene.analysis.range_m;
    return range_m > 0 ? range_m / view.voxel_m : core::kFar;
}

// By its place in the world, not in the raster: a cell has the same value in every raster.
std::uint64_t name_of_cell(core::Vec3 at) noexcept {
    constexpr double kSteps = 1024;  // column_descent places rays on this grid
    const auto x = static_cast<std::int64_t>(at.x * kSteps);
    const auto z = static_cast<std::int64_t>(at.z * kSteps);
    return core::hash64(static_cast<std::uint64_t>(x), static_cast<std::uint64_t>(z));
}

enum class SkyBand : std::uint8_t {
    kHole,
    kCosine,    ///< sky-view factor: share of the sky's light on a level surface, [0, 1]
    kSolid,     ///< share of the solid angle above the horizon, [0, 1]
    kOpenness,  ///< mean over all azimuths of the free zenith angle, degrees, [0, 90]
};

constexpr RasterBand kSkyBands[] = {
    {"svf", "", {"Sky-view factor", Ramp::kMuch, 0.0, 1.0}},
    {"sky_view_solid", "", {"Share of the sky", Ramp::kMuch, 0.0, 1.0}},
    {"openness", "degree", {"Openness", Ramp::kMuch, 0.0, 90.0}},
    kHoleBand,
};

/// Measures SkyBand: from the middle of each cell's top, or of its ground, rays in all
/// directions of the upper half of a sphere. A voxel of any material blocks them, leaves and panes
/// as well; what lies outside of the world's bounds does not.
class SkyEvaluator final : public CellEvaluator {
public:
    SkyEvaluator(const shade::View& view, const Sunlight& sunlight)
        : m_view(view),
          m_sunlight(sunlight),
          m_directions(view.scene.analysis.directions),
          m_fans(to_fan(m_directions.count() - 1) + 1),
          m_range(make_range(view)) {}

    void shade(const walk::TracedRay& ray, shade::SampleSum& sum,
               std::vector<walk::TracedRay>& next) const override {
        if (!lands(ray, m_view, sum, next))
            return;
        sum.bands = {};
        send_to_sky(start_above(ray), SkyDirections::choose_set(name_of_cell(ray.ray.origin)), 0,
                    next);
    }
    [[nodiscard]] walk::FanDirections directions(std::uint32_t stream) const override {
        const Part part = find_part(stream);
        walk::FanDirections out;
        for (std::size_t i = part.first; i < part.end; ++i)
            out.add(m_directions.of(part.set)[i].to);
        return out;
    }
    void shade_fan(const walk::TracedRay& fan, walk::FanEnds ends, shade::SampleSum& sum,
                   std::vector<walk::TracedRay>& next) const override {
        if (ends.holes != 0) {
            sum.bands = no_values(true);
            return;
        }
        const Part part = find_part(fan.stream);
        const auto directions = m_directions.of(part.set);
        const walk::FanMask free = free_rays(fan, ends, *this, m_sunlight);
        for (std::size_t i = part.first; i < part.end; ++i) {
            if (!walk::has(free, i - part.first))
                continue;
            const voxel::Colour& share = directions[i].share;
            at(sum.bands, SkyBand::kCosine) += share.r;
            at(sum.bands, SkyBand::kSolid) += share.g;
            at(sum.bands, SkyBand::kOpenness) += share.b * kZenithAngle_deg;
        }
        if (part.end < directions.size())
            send_to_sky(find_start(fan), part.set, part.end, next);
    }

private:
    /// A part of a set of directions.
    struct Part {
        std::size_t set;
        std::size_t first;  ///< direction of the set
        std::size_t end;
    };
    /// The part that fans of a stream look at.
    [[nodiscard]] Part find_part(std::uint32_t stream) const noexcept {
        const std::size_t first = stream % m_fans * walk::kFanRays;
        return {stream / m_fans, first, fan_end(first, m_directions.count())};
    }
    void send_to_sky(const FanStart& start, std::size_t set, std::size_t first,
                     std::vector<walk::TracedRay>& next) const {
        const std::size_t end = fan_end(first, m_directions.count());
        walk::TracedRay& fan =
            add_fan(start, walk::RayKind::kSky, walk::mask_of_first(end - first),
                    static_cast<std::uint32_t>(set) * m_fans + to_fan(first), next);
        fan.t_max = m_range;
    }
    const shade::View& m_view;
    const Sunlight& m_sunlight;
    const SkyDirections m_directions;
    const std::uint32_t m_fans;  ///< of a set
    const double m_range;        ///< level-0 voxels
};

}  // namespace

template <>
constexpr Analysis kAnalysis<AnalysisKind::kSky>{kSkyBands, make<SkyEvaluator>, SunUse::kNone,
                                                 SkyUse::kFromCells};
template const Analysis& find_analysis<AnalysisKind::kSky>() noexcept;

}  // namespace terravox::analyse
