#include "raytracer/analyse/plane_light.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <memory>

#include "common/util/det_math.hpp"
#include "raytracer/analyse/column_descent.hpp"
#include "raytracer/analyse/evaluator.hpp"
#include "raytracer/core/thin_materials.hpp"

namespace terravox::analyse {
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
    float waiting = 0;  ///< rays of the chunk that are on their way
    float kept = 0;

    [[nodiscard]] static Gathered of(const core::Bands& bands) noexcept {
        return std::bit_cast<Gathered>(bands);
    }
    void keep_in(core::Bands& bands) const noexcept { bands = std::bit_cast<core::Bands>(*this); }
};
static_assert(sizeof(Gathered) == sizeof(core::Bands));
static_assert(offsetof(Gathered, kept) == PlaneLight::kKept * sizeof(float));

core::Vec3 normal_of(const Gathered& gathered) noexcept {
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

int level_of(float edge) noexcept {
    return std::ilogb(edge);
}

/// What light of a direction reaches the plane.
enum class Passage : std::uint8_t { kBlocked, kThroughCrowns, kFree };

/// Adds the light of one direction.
void add(const solar::Energy& energy, std::size_t index, core::Vec3 to, Passage passage,
         Gathered& gathered) noexcept {
    const bool is_free = passage != Passage::kBlocked;
    const bool has_passed = passage == Passage::kThroughCrowns;
    const double cosine = std::max(core::dot(normal_of(gathered), to), 0.0);
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

PlaneLight::PlaneLight(const shade::View& view, Behind behind) noexcept
    : m_view(view),
      m_behind(behind),
      m_crowns_shine(lets_light_through_crowns(view.energy)),
      m_thin_passes(thin_things(view) == walk::ThinThings::kPass) {}

std::size_t PlaneLight::directions() const noexcept {
    return m_view.energy.sun.size() + m_view.energy.sky.size();
}

core::Vec3 PlaneLight::direction(std::size_t index) const noexcept {
    const std::size_t suns = m_view.energy.sun.size();
    return index < suns ? m_view.energy.sun[index].to : m_view.energy.sky[index - suns];
}

bool PlaneLight::begin(core::Vec3 normal, float kept, const Start& start, shade::SampleSum& sum,
                       std::vector<walk::TracedRay>& next) const {
    Gathered gathered;
    gathered.east = static_cast<float>(normal.x);
    gathered.up = static_cast<float>(normal.y);
    gathered.south = static_cast<float>(normal.z);
    gathered.kept = kept;
    gathered.keep_in(sum.bands);
    return send(start, 0, sum, next);
}

bool PlaneLight::send(const Start& start, std::size_t first, shade::SampleSum& sum,
                      std::vector<walk::TracedRay>& next) const {
    const auto edge = static_cast<float>(det::exp2_int(start.level));
    const core::VoxelCoord voxel = voxel_at(start.at, start.level);
    auto gathered = Gathered::of(sum.bands);
    const core::Vec3 normal = normal_of(gathered);
    gathered.waiting = 0;
    while (first < directions() && gathered.waiting == 0) {
        const std::size_t end = chunk_end(first, directions());
        for (; first < end; ++first) {
            const core::Vec3 to = direction(first);
            if (m_behind == Behind::kFree && core::dot(normal, to) <= 0) {
                add(m_view.energy, first, to, Passage::kFree, gathered);
                continue;
            }
            gathered.waiting += 1;
            walk::TracedRay& out = next.emplace_back();
            out.ray = {start.at, to};
            // Built in place: to copy a ray right after it is written stalls the processor.
            std::construct_at(&out.state, out.ray);
            out.state.start_in(voxel, start.level);
            // For the rays that follow it: the edge of the voxel from which it comes.
            out.footprint = edge;
            out.sample = start.sample;
            out.stream = static_cast<std::uint32_t>(first);
            out.kind = walk::RayKind::kShadow;
        }
    }
    gathered.keep_in(sum.bands);
    return gathered.waiting == 0;
}

bool PlaneLight::lets_through(voxel::Material material) const noexcept {
    return is_crown(material) || (m_thin_passes && core::is_thin(material));
}

bool PlaneLight::sends_through_crowns(const walk::TracedRay& ray,
                                      std::vector<walk::TracedRay>& next) const {
    // A walk passes one material: crowns of more layers than this are as dark as walls.
    constexpr std::uint8_t kMaxWalks = 32;
    const bool is_first = ray.depth == 0;
    if (!m_crowns_shine || ray.end != walk::WalkEnd::kHit || ray.depth == kMaxWalks ||
        (!is_first && !lets_through(ray.hit.attr.material)))
        return false;
    walk::TracedRay out = ray;
    out.state = core::RayState(out.ray);
    if (is_first) {
        // What has blocked it is not known, so it starts again.
        const int level = level_of(ray.footprint);
        out.state.start_in(voxel_at(ray.ray.origin, level), level);
        out.stop = {voxel::Material::kHighVegetation, false};
    } else {
        out.state.start_in(ray.hit.voxel, ray.hit.level);
        out.state.t = ray.hit.t;
        out.state.face = ray.hit.face;
        out.stop = {ray.hit.attr.material, false};
    }
    out.end = walk::WalkEnd::kWaits;
    out.kind = walk::RayKind::kSky;
    out.depth = static_cast<std::uint8_t>(ray.depth + 1);
    next.push_back(out);
    return true;
}

bool PlaneLight::take(const walk::TracedRay& ray, shade::SampleSum& sum,
                      std::vector<walk::TracedRay>& next) const {
    if (sends_through_crowns(ray, next))
        return false;
    Passage passage = ray.depth > 0 ? Passage::kThroughCrowns : Passage::kFree;
    if (!is_free(ray, m_view))
        passage = Passage::kBlocked;
    auto gathered = Gathered::of(sum.bands);
    add(m_view.energy, ray.stream, ray.ray.direction, passage, gathered);
    gathered.waiting -= 1;
    gathered.keep_in(sum.bands);
    if (gathered.waiting > 0)
        return false;
    const std::size_t end = chunk_end(ray.stream / kChunkRays * kChunkRays, directions());
    return send({ray.ray.origin, level_of(ray.footprint), ray.sample}, end, sum, next);
}

PlaneLight::Result PlaneLight::result(const core::Bands& bands) const noexcept {
    const auto gathered = Gathered::of(bands);
    const solar::Energy& energy = m_view.energy;
    Result out;
    out.normal = normal_of(gathered);
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
    out.reflected = m_view.scene.analysis.albedo * level * (1 - out.sky_view);
    out.beam = static_cast<double>(gathered.beam);
    out.sun_hours = gathered.sun_hours;
    out.kept = gathered.kept;
    return out;
}

}  // namespace terravox::analyse
