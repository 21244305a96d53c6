#include <algorithm>

#include "raytracer/analyse/evaluators/cell_evaluator.hpp"

namespace terravox::analyse {
namespace {

using core::AnalysisKind;

enum class SunBand : std::uint8_t {
    kHole,
    kHours,  ///< of direct sun
    kFirst,  ///< clock time at which the first sunlit step begins, hours
    kLast,   ///< clock time at which the last one ends
};

enum class SunPeriodBand : std::uint8_t {
    kHole,
    kHours,   ///< of direct sun in the period
    kPerDay,  ///< its mean over the days of the period, hours
    kShare,   ///< of the time for which the sun is above a level horizon, [0, 1]
};

enum class SunMonthsBand : std::uint8_t {
    kHole,
    kHours,    ///< of direct sun in the period
    kJanuary,  ///< hours of all Januaries in the period; those of February follow, ...
};

enum class ShadowBand : std::uint8_t {
    kHole,
    kSunlit,  ///< 1: in the sun; 0: in shadow, or the sun is below the horizon
};

void add_to_day(const solar::SunDirection& from, core::Bands& bands) noexcept {
    const auto begin = static_cast<float>(from.begin_h);
    const auto end = static_cast<float>(from.end_h);
    at(bands, SunBand::kHours) += static_cast<float>(from.hours);
    float& first = at(bands, SunBand::kFirst);
    float& last = at(bands, SunBand::kLast);
    first = first == core::kNoData ? begin : std::min(first, begin);
    last = std::max(last, end);
}

void add_to_period(const solar::SunDirection& from, const solar::SunWay& way,
                   core::Bands& bands) noexcept {
    at(bands, SunPeriodBand::kHours) += static_cast<float>(from.hours);
    at(bands, SunPeriodBand::kPerDay) += static_cast<float>(from.hours / way.days);
    at(bands, SunPeriodBand::kShare) += static_cast<float>(from.hours / way.hours);
}

void add_to_months(const solar::SunDirection& from, core::Bands& bands) noexcept {
    at(bands, SunMonthsBand::kHours) += static_cast<float>(from.hours);
    float* const month = &at(bands, SunMonthsBand::kJanuary);
    for (std::size_t m = 0; m < from.month_hours.size(); ++m)
        month[m] += from.month_hours[m];
}

constexpr RasterBand kSunBands[] = {
    kSunHoursBand,
    {"first_sun", "h", {"First sun, clock time", Ramp::kMuch, {}, {}, true, kClock}},
    {"last_sun", "h", {"Last sun, clock time", Ramp::kMuch, {}, {}, true, kClock}},
    kHoleBand,
};

constexpr RasterBand kSunPeriodBands[] = {
    kSunHoursBand,
    {"sun_hours_per_day", "h", {"Hours of direct sun a day", Ramp::kWarm, 0.0}},
    {"sun_share", "", {"Share of daylight in the sun", Ramp::kWarm, 0.0, 1.0, kNotReported}},
    kHoleBand,
};

constexpr RasterBand month(std::string_view name) noexcept {
    return {name, "h", {name, Ramp::kWarm, 0.0, {}, kNotReported}};
}
constexpr RasterBand kSunMonthsBands[] = {
    kSunHoursBand,    month("january"),  month("february"), month("march"),  month("april"),
    month("may"),     month("june"),     month("july"),     month("august"), month("september"),
    month("october"), month("november"), month("december"), kHoleBand,
};

constexpr RasterBand kShadowBands[] = {
    {"sunlit", "", {"In the sun", Ramp::kWarm, 0.0, 1.0}},
    kHoleBand,
};

/// Measures the sun's bands (SunBand and others, by the kind): from the middle of each cell's
/// top, or of its ground, a ray in each direction of the view's sun way. Whatever blocks it puts
/// the cell into shadow for all of the direction's time.
class SunEvaluator final : public CellEvaluator {
public:
    SunEvaluator(const shade::View& view, const Sunlight& sunlight) noexcept
        : m_view(view), m_sunlight(sunlight) {}

    void shade(const walk::TracedRay& ray, shade::SampleSum& sum,
               std::vector<walk::TracedRay>& next) const override {
        if (!lands(ray, m_view, sum, next))
            return;
        sum.bands = without_sun();
        send_to_sun(start_above(ray), 0, next);
    }
    [[nodiscard]] walk::FanDirections directions(std::uint32_t stream) const override {
        const auto& all = m_sunlight.sun_way.directions;
        const std::size_t first = stream * walk::kFanRays;
        walk::FanDirections out;
        for (std::size_t i = first; i < fan_end(first, all.size()); ++i)
            out.add(all[i].to);
        return out;
    }
    void shade_fan(const walk::TracedRay& fan, walk::FanEnds ends, shade::SampleSum& sum,
                   std::vector<walk::TracedRay>& next) const override {
        if (ends.holes != 0) {
            sum.bands = no_values(true);
            return;
        }
        const auto& all = m_sunlight.sun_way.directions;
        const std::size_t first = fan.stream * walk::kFanRays;
        const std::size_t end = fan_end(first, all.size());
        const walk::FanMask free = free_rays(fan, ends, *this, m_sunlight);
        for (std::size_t i = first; i < end; ++i)
            if (walk::has(free, i - first))
                add_sunlit(all[i], sum.bands);
        send_to_sun(find_start(fan), end, next);
    }

private:
    [[nodiscard]] core::Bands without_sun() const noexcept {
        core::Bands out{};
        if (m_view.scene.analysis.kind == AnalysisKind::kSun) {
            at(out, SunBand::kFirst) = core::kNoData;
            at(out, SunBand::kLast) = core::kNoData;
        }
        return out;
    }
    void add_sunlit(const solar::SunDirection& from, core::Bands& bands) const noexcept {
        switch (m_view.scene.analysis.kind) {
            case AnalysisKind::kSun: add_to_day(from, bands); break;
            case AnalysisKind::kSunPeriod: add_to_period(from, m_sunlight.sun_way, bands); break;
            case AnalysisKind::kSunMonths: add_to_months(from, bands); break;
            default: at(bands, ShadowBand::kSunlit) = 1; break;
        }
    }
    /// Sends the fan that begins with direction `first`, if there are so many.
    void send_to_sun(const FanStart& start, std::size_t first,
                     std::vector<walk::TracedRay>& next) const {
        const std::size_t end = fan_end(first, m_sunlight.sun_way.directions.size());
        if (first < end)
            add_fan(start, walk::RayKind::kShadow, walk::mask_of_first(end - first), to_fan(first),
                    next);
    }
    const shade::View& m_view;
    const Sunlight& m_sunlight;
};

/// Shows how long the sun shines on what a camera sees, on one day: for the window, where it
/// becomes finer with each sample. The red channel of a sample is the share of the view's sun way
/// in which the first face that its ray meets is in the sun, the green channel is 1 where data is
/// missing. Each sample looks at kRays moments, evenly over the day from a random one on.
class SunViewEvaluator final : public shade::RayEvaluator {
public:
    static constexpr std::size_t kRays = 8;

    SunViewEvaluator(const shade::View& /*view*/, const Sunlight& sunlight) noexcept
        : m_sunlight(sunlight) {}

    [[nodiscard]] std::size_t wave_pixels(std::size_t rays) const noexcept override {
        return std::min(rays, kMostWaveCells);
    }
    [[nodiscard]] walk::TracedRay primary(const core::Ray& ray,
                                          std::uint32_t sample) const noexcept override {
        walk::TracedRay out;
        out.ray = ray;
        out.sample = sample;
        return out;
    }
    [[nodiscard]] bool needs_surroundings(const walk::TracedRay& /*ray*/) const noexcept override {
        return false;
    }
    void shade(const walk::TracedRay& ray, shade::SampleSum& sum,
               std::vector<walk::TracedRay>& next) const override {
        if (is_hole(ray))
            sum.direct.g = 1;
        else if (ray.end == walk::WalkEnd::kHit)
            shade_face(ray, sum, next);
    }
    // Each pixel has moments of its own: its fans have one ray.
    [[nodiscard]] walk::FanDirections directions(std::uint32_t stream) const override {
        walk::FanDirections out;
        out.add(m_sunlight.sun_way.directions[stream].to);
        return out;
    }
    void shade_fan(const walk::TracedRay& fan, walk::FanEnds ends, shade::SampleSum& sum,
                   std::vector<walk::TracedRay>& /*next*/) const override {
        if (ends.holes != 0)
            sum.direct.g = 1;
        else if (free_rays(fan, ends, *this, m_sunlight) != 0)
            sum.direct.r += fan.weight.r;
    }

private:
    void shade_face(const walk::TracedRay& ray, shade::SampleSum& sum,
                    std::vector<walk::TracedRay>& next) const {
        sum.t = ray.hit.t;
        const auto& directions = m_sunlight.sun_way.directions;
        if (ray.hit.face == core::Face::kNone || directions.empty())
            return;
        const core::Vec3 normal = core::to_normal(ray.hit.face);
        const core::Vec3 from = ray.ray.origin + ray.ray.direction * ray.hit.t;
        const FanStart start{from, walk::neighbour(ray.hit.voxel, ray.hit.face), ray.hit.level,
                             ray.sample};
        const auto count = static_cast<double>(directions.size());
        const std::size_t rays = std::min(kRays, directions.size());
        const double first = sum.numbers.number(0);
        for (std::size_t i = 0; i < rays; ++i) {
            const double share = (static_cast<double>(i) + first) / static_cast<double>(rays);
            const auto index =
                std::min(static_cast<std::size_t>(share * count), directions.size() - 1);
            const solar::SunDirection& sun = directions[index];
            if (core::dot(normal, sun.to) <= 0)
                continue;
            walk::TracedRay& out = add_fan(start, walk::RayKind::kShadow, walk::mask_of_first(1),
                                           static_cast<std::uint32_t>(index), next);
            out.weight.r = static_cast<float>(sun.hours / m_sunlight.sun_way.hours * count /
                                              static_cast<double>(rays));
        }
    }
    const Sunlight& m_sunlight;
};

}  // namespace

template <>
constexpr Analysis kAnalysis<AnalysisKind::kSun>{kSunBands, make<SunEvaluator>, SunUse::kWay,
                                                 SkyUse::kFromCells};
template const Analysis& find_analysis<AnalysisKind::kSun>() noexcept;
template <>
constexpr Analysis kAnalysis<AnalysisKind::kSunPeriod>{kSunPeriodBands, make<SunEvaluator>,
                                                       SunUse::kWay, SkyUse::kFromCells};
template const Analysis& find_analysis<AnalysisKind::kSunPeriod>() noexcept;
template <>
constexpr Analysis kAnalysis<AnalysisKind::kSunMonths>{kSunMonthsBands, make<SunEvaluator>,
                                                       SunUse::kWay, SkyUse::kFromCells};
template const Analysis& find_analysis<AnalysisKind::kSunMonths>() noexcept;
template <>
constexpr Analysis kAnalysis<AnalysisKind::kShadow>{kShadowBands, make<SunEvaluator>, SunUse::kWay,
                                                    SkyUse::kFromCells};
template const Analysis& find_analysis<AnalysisKind::kShadow>() noexcept;
template <>
constexpr Analysis kAnalysis<AnalysisKind::kSunView>{{}, make<SunViewEvaluator>, SunUse::kWay};
template const Analysis& find_analysis<AnalysisKind::kSunView>() noexcept;

}  // namespace terravox::analyse
