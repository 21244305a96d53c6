#include "raytracer/analyse/evaluators/plane_light.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>

#include "common/util/det_math.hpp"
#include "raytracer/analyse/evaluators/cell_evaluator.hpp"
#include "raytracer/core/base/material_groups.hpp"

namespace terravox::analyse {

void HeightSums::add(int east, int south, float height) noexcept {
    const auto x = static_cast<float>(east);
    const auto y = static_cast<float>(south);
    count += 1;
    e += x;
    s += y;
    h += height;
    ee += x * x;
    es += x * y;
    ss += y * y;
    eh += x * height;
    sh += y * height;
    hh += height * height;
}

bool is_same_surface(double distance, double height, double step) noexcept {
    constexpr double kSteepest = 1.5;
    return std::abs(height) <= kSteepest * distance + step;
}

core::Vec3 CellPlane::normal() const noexcept {
    return core::normalized({-east, 1, -south});
}

double azimuth_deg(core::Vec3 normal) noexcept {
    constexpr double kDegPerRad = 180 / det::kPi;
    const double azimuth = det::atan2(normal.x, 0 - normal.z) * kDegPerRad;
    return azimuth < 0 ? azimuth + 360 : azimuth;
}

CellPlane plane_through(const HeightSums& sums, double spacing, double step) noexcept {
    const auto n = static_cast<double>(sums.count);
    const auto product = [n](float of_both, float a, float b) {
        return n * static_cast<double>(of_both) - static_cast<double>(a) * static_cast<double>(b);
    };
    const double ee = product(sums.ee, sums.e, sums.e);
    const double es = product(sums.es, sums.e, sums.s);
    const double ss = product(sums.ss, sums.s, sums.s);
    const double eh = product(sums.eh, sums.e, sums.h);
    const double sh = product(sums.sh, sums.s, sums.h);
    const double hh = product(sums.hh, sums.h, sums.h);
    const double det = ee * ss - es * es;
    if (det <= 0)
        return {};
    // Per step of a cell.
    const double east = (eh * ss - sh * es) / det;
    const double south = (sh * ee - eh * es) / det;
    const double at_cell = (static_cast<double>(sums.h) - east * static_cast<double>(sums.e) -
                            south * static_cast<double>(sums.s)) /
                           n;
    const double residual = std::sqrt(std::max(hh - east * eh - south * sh, 0.0)) / n;
    CellPlane out;
    out.east = east / spacing;
    out.south = south / spacing;
    // Voxels reach above the plane by half of their edge times its slope, and by what rounding of
    // heights to voxels makes of it.
    constexpr double kDeviations = 1.75;
    out.lift = std::max(at_cell, 0.0) + 0.5 * step * (std::abs(out.east) + std::abs(out.south)) +
               kDeviations * residual;
    return out;
}

namespace {

struct Gathered {
    float hole = 0;
    float east = 0, up = 1, south = 0;  ///< the plane's normal
    float beam = 0;                     ///< on the plane, kWh/m2
    float around_sun = 0;               ///< the same
    float level = 0;                    ///< both, on a level surface
    // Of the sky: sums of cosines of its directions with the plane's normal, and with the zenith.
    float sky = 0, free_sky = 0;  ///< all, and those that nothing blocks
    float level_sky = 0, free_level_sky = 0;
    float horizon = 0, free_horizon = 0;
    float sun_hours = 0;
    float waiting = 0;  ///< fans and rays through crowns that are on their way
    float kept = 0;

    [[nodiscard]] static Gathered of(const core::Bands& bands) noexcept {
        return std::bit_cast<Gathered>(bands);
    }
    void keep_in(core::Bands& bands) const noexcept { bands = std::bit_cast<core::Bands>(*this); }
};
static_assert(sizeof(Gathered) == sizeof(core::Bands));
static_assert(offsetof(Gathered, kept) == PlaneLight::kKept * sizeof(float));

core::Vec3 to_normal(const Gathered& gathered) noexcept {
    return {static_cast<double>(gathered.east), static_cast<double>(gathered.up),
            static_cast<double>(gathered.south)};
}

double share(float part, float whole) noexcept {
    return whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : 0;
}

/// Whether a material belongs to what --crown-light lets light through.
bool is_crown(voxel::Material material) noexcept {
    return material == voxel::Material::kMediumVegetation ||
           material == voxel::Material::kHighVegetation;
}

bool lets_light_through_crowns(const solar::Energy& energy) noexcept {
    return energy.through_crowns > 0 ||
           std::any_of(energy.sun.begin(), energy.sun.end(),
                       [](const auto& light) { return light.through_crowns > 0; });
}

/// What light of a direction reaches the plane.
enum class Passage : std::uint8_t { kBlocked, kThroughCrowns, kFree };

/// Adds the light of one direction.
void add(const solar::Energy& energy, std::size_t index, core::Vec3 to, Passage passage,
         Gathered& gathered) noexcept {
    const bool is_free = passage != Passage::kBlocked;
    const bool has_passed = passage == Passage::kThroughCrowns;
    const double cosine = std::max(core::dot(to_normal(gathered), to), 0.0);
    if (index < energy.sun.size()) {
        const solar::LightDirection& light = energy.sun[index];
        const double passed = has_passed ? light.through_crowns : 1;
        if (!is_free)
            return;
        gathered.beam += static_cast<float>(light.beam * passed * cosine);
        gathered.around_sun += static_cast<float>(light.around_sun * passed * cosine);
        gathered.level += static_cast<float>((light.beam + light.around_sun) * passed * to.y);
        gathered.sun_hours += cosine > 0 && !has_passed ? static_cast<float>(light.hours) : 0.0F;
        return;
    }
    const auto part = static_cast<float>(cosine);
    const auto level = static_cast<float>(to.y);
    const float low = to.y < solar::kHorizonSine ? part : 0.0F;
    const double passed = has_passed ? energy.through_crowns : 1;
    const float free = is_free ? static_cast<float>(passed) : 0.0F;
    gathered.sky += part;
    gathered.free_sky += part * free;
    gathered.level_sky += level;
    gathered.free_level_sky += level * free;
    gathered.horizon += low;
    gathered.free_horizon += low * free;
}

}  // namespace

PlaneLight::PlaneLight(const shade::View& view, const Sunlight& sunlight, Behind behind) noexcept
    : m_sunlight(sunlight),
      m_albedo(view.scene.analysis.albedo),
      m_behind(behind),
      m_crowns_shine(lets_light_through_crowns(sunlight.energy)),
      m_thin_passes(sunlight.thin_things == walk::ThinThings::kPass) {}

std::size_t PlaneLight::count() const noexcept {
    return m_sunlight.energy.sun.size() + m_sunlight.energy.sky.size();
}

core::Vec3 PlaneLight::direction(std::size_t index) const noexcept {
    const std::size_t suns = m_sunlight.energy.sun.size();
    return index < suns ? m_sunlight.energy.sun[index].to : m_sunlight.energy.sky[index - suns];
}

walk::FanDirections PlaneLight::directions(std::uint32_t stream) const noexcept {
    const std::size_t first = stream * walk::kFanRays;
    walk::FanDirections out;
    for (std::size_t i = first; i < fan_end(first, count()); ++i)
        out.add(direction(i));
    return out;
}

bool PlaneLight::begin(core::Vec3 normal, float kept, const FanStart& start, shade::SampleSum& sum,
                       std::vector<walk::TracedRay>& next) const {
    Gathered gathered;
    gathered.east = static_cast<float>(normal.x);
    gathered.up = static_cast<float>(normal.y);
    gathered.south = static_cast<float>(normal.z);
    gathered.kept = kept;
    gathered.keep_in(sum.bands);
    return send(start, 0, sum, next);
}

bool PlaneLight::send(const FanStart& start, std::size_t first, shade::SampleSum& sum,
                      std::vector<walk::TracedRay>& next) const {
    auto gathered = Gathered::of(sum.bands);
    const core::Vec3 normal = to_normal(gathered);
    gathered.waiting = 0;
    for (; first < count() && gathered.waiting == 0; first = fan_end(first, count())) {
        walk::FanMask mask = walk::mask_of_first(fan_end(first, count()) - first);
        for (std::size_t i = first; m_behind == Behind::kFree && i < fan_end(first, count()); ++i) {
            const core::Vec3 to = direction(i);
            if (core::dot(normal, to) > 0)
                continue;
            add(m_sunlight.energy, i, to, Passage::kFree, gathered);
            mask = static_cast<walk::FanMask>(mask & ~(1U << (i - first)));
        }
        if (mask == 0)
            continue;
        add_fan(start, walk::RayKind::kShadow, mask, to_fan(first), next);
        gathered.waiting = 1;
    }
    gathered.keep_in(sum.bands);
    return gathered.waiting == 0;
}

bool PlaneLight::lets_through(voxel::Material material) const noexcept {
    return is_crown(material) || (m_thin_passes && core::is_thin(material));
}

void PlaneLight::send_through_crowns(const walk::TracedRay& fan, std::size_t index,
                                     std::vector<walk::TracedRay>& next) const {
    const FanStart start = find_start(fan);
    walk::TracedRay& out = next.emplace_back();
    out.ray = {start.at, direction(index)};
    out.state = core::RayState(out.ray);
    out.state.start_in(start.voxel, start.level);
    out.stop = {voxel::Material::kHighVegetation, false};
    out.kind = walk::RayKind::kSky;
    out.depth = 1;
    out.stream = static_cast<std::uint32_t>(index);
    out.sample = start.sample;
    // For the fan that follows: the edge of the voxel in which it starts.
    out.footprint = static_cast<float>(det::exp2_int(start.level));
}

bool PlaneLight::goes_on_through_crowns(const walk::TracedRay& ray,
                                        std::vector<walk::TracedRay>& next) const {
    // A walk passes one material: crowns of more layers than this are as dark as walls.
    constexpr std::uint8_t kMaxWalks = 32;
    if (ray.end != walk::WalkEnd::kHit || ray.depth == kMaxWalks ||
        !lets_through(ray.hit.attr.material))
        return false;
    next.push_back(through(ray));
    next.back().depth = static_cast<std::uint8_t>(ray.depth + 1);
    return true;
}

bool PlaneLight::take_fan(const walk::TracedRay& fan, walk::FanEnds ends,
                          const shade::RayEvaluator& evaluator, shade::SampleSum& sum,
                          std::vector<walk::TracedRay>& next) const {
    auto gathered = Gathered::of(sum.bands);
    gathered.waiting = 0;
    const std::size_t first = fan.stream * walk::kFanRays;
    const std::size_t end = fan_end(first, count());
    const walk::FanMask free = free_rays(fan, ends, evaluator, m_sunlight);
    for (std::size_t i = first; i < end; ++i) {
        if (!walk::has(fan.fan_mask, i - first))
            continue;
        if (m_crowns_shine && walk::has(ends.blocked, i - first)) {
            send_through_crowns(fan, i, next);
            gathered.waiting += 1;
            continue;
        }
        const bool is_free = walk::has(free, i - first);
        add(m_sunlight.energy, i, direction(i), is_free ? Passage::kFree : Passage::kBlocked,
            gathered);
    }
    gathered.keep_in(sum.bands);
    return gathered.waiting == 0 && send(find_start(fan), end, sum, next);
}

bool PlaneLight::take_through_crowns(const walk::TracedRay& ray, shade::SampleSum& sum,
                                     std::vector<walk::TracedRay>& next) const {
    if (goes_on_through_crowns(ray, next))
        return false;
    const Passage passage = is_free(ray, m_sunlight) ? Passage::kThroughCrowns : Passage::kBlocked;
    auto gathered = Gathered::of(sum.bands);
    add(m_sunlight.energy, ray.stream, ray.ray.direction, passage, gathered);
    gathered.waiting -= 1;
    gathered.keep_in(sum.bands);
    if (gathered.waiting > 0)
        return false;
    const std::size_t first = to_fan(ray.stream) * walk::kFanRays;
    const FanStart start = start_at(ray.ray.origin, std::ilogb(ray.footprint), ray.sample);
    return send(start, fan_end(first, count()), sum, next);
}

PlaneLight::Result PlaneLight::result(const core::Bands& bands) const noexcept {
    const auto gathered = Gathered::of(bands);
    const solar::Energy& energy = m_sunlight.energy;
    Result out;
    out.normal = to_normal(gathered);
    const double upward = out.normal.y;
    const double sine = std::sqrt(out.normal.x * out.normal.x + out.normal.z * out.normal.z);
    // The part of the plane's light that an even sky sends: exact where nothing is in the way.
    out.sky_view = (1 + upward) / 2 * share(gathered.free_sky, gathered.sky);
    out.diffuse =
        std::max(0.0, energy.isotropic * out.sky_view + static_cast<double>(gathered.around_sun) +
                          energy.horizon * sine * share(gathered.free_horizon, gathered.horizon));
    const double level = static_cast<double>(gathered.level) +
                         energy.isotropic * share(gathered.free_level_sky, gathered.level_sky);
    // What is not sky is lit like a level surface here, and reflects evenly.
    out.reflected = m_albedo * level * (1 - out.sky_view);
    out.beam = static_cast<double>(gathered.beam);
    out.sun_hours = gathered.sun_hours;
    out.kept = gathered.kept;
    return out;
}

}  // namespace terravox::analyse
