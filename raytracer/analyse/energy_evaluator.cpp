#include "raytracer/analyse/energy_evaluator.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>

#include "common/util/det_math.hpp"
#include "raytracer/analyse/bands.hpp"
#include "raytracer/analyse/column_descent.hpp"

namespace terravox::analyse {
namespace {

using core::EnergyBand;

// The plane goes through the heights of so many cells a side.
constexpr int kWindow = 5;
constexpr int kRadius = kWindow / 2;
constexpr std::uint32_t kNeighbours = kWindow * kWindow;
constexpr std::uint32_t kOfCell = kNeighbours / 2;  ///< place of the cell itself in the window

// What a cell knows while its rays are on their way is kept in its bands: first the heights around
// it, then its plane and the light that has reached it. Its band of holes stays where it is.
struct Heights {
    float hole = 0;
    float top = 0;      ///< of the cell, level-0 voxels
    float level = 0;    ///< of its voxel
    float waiting = 0;  ///< neighbours whose rays are on their way
    HeightSums sums;
    float unused = 0;
    float material = 0;
};
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
    float material = 0;
};
static_assert(sizeof(Heights) == sizeof(core::Bands) && sizeof(Gathered) == sizeof(core::Bands));
static_assert(offsetof(Heights, material) == offsetof(Gathered, material));
constexpr std::size_t kHole = static_cast<std::size_t>(EnergyBand::kHole);
static_assert(kHole == 0);

template <class Memory>
Memory memory_of(const core::Bands& bands) noexcept {
    return std::bit_cast<Memory>(bands);
}
template <class Memory>
void keep(const Memory& memory, core::Bands& bands) noexcept {
    bands = std::bit_cast<core::Bands>(memory);
}

int east_of(std::uint32_t place) noexcept {
    return static_cast<int>(place % kWindow) - kRadius;
}
int south_of(std::uint32_t place) noexcept {
    return static_cast<int>(place / kWindow) - kRadius;
}

/// What is left of a cell, one of whose rays has met a hole.
core::Bands behind_hole(const core::Bands& memory) noexcept {
    core::Bands out = no_values(kHole, true);
    at(out, EnergyBand::kMaterial) = memory_of<Gathered>(memory).material;
    return out;
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

/// @param edge of the voxel, level-0 voxels
core::VoxelCoord voxel_at(core::Vec3 at, float edge) noexcept {
    const double scale = 1 / static_cast<double>(edge);
    return {core::RayState::floor_to_int(at.x * scale), core::RayState::floor_to_int(at.y * scale),
            core::RayState::floor_to_int(at.z * scale)};
}

double spacing_of(const shade::View& view) noexcept {
    const auto& scene = view.scene;
    return scene.camera.height_m.value_or(0) / scene.output.size_px[1] / view.voxel_m;
}

core::Vec3 normal_of(const Gathered& gathered) noexcept {
    return {static_cast<double>(gathered.east), static_cast<double>(gathered.up),
            static_cast<double>(gathered.south)};
}

double share(float part, float whole) noexcept {
    return whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : 0;
}

}  // namespace

EnergyEvaluator::EnergyEvaluator(const shade::View& view) noexcept
    : m_view(view),
      m_spacing(spacing_of(view)),
      m_crowns_shine(lets_light_through_crowns(view.energy)) {}

walk::TracedRay EnergyEvaluator::primary(const core::Ray& ray,
                                         std::uint32_t sample) const noexcept {
    walk::TracedRay out = cell_ray(ray, sample);
    out.stream = kOfCell;
    return out;
}

bool EnergyEvaluator::needs_surroundings(const walk::TracedRay& /*ray*/) const noexcept {
    return false;
}

void EnergyEvaluator::shade(const walk::TracedRay& ray, shade::SampleSum& sum,
                            std::vector<walk::TracedRay>& next) const {
    if (ray.kind == walk::RayKind::kPrimary && ray.stream == kOfCell) {
        shade_cell(ray, sum, next);
        return;
    }
    if (sum.bands[kHole] > 0)
        return;
    if (ray.end == walk::WalkEnd::kHit && ray.hit.hole)
        sum.bands = behind_hole(sum.bands);
    else if (ray.kind == walk::RayKind::kPrimary)
        shade_neighbour(ray, sum, next);
    else
        shade_light(ray, sum, next);
}

void EnergyEvaluator::shade_cell(const walk::TracedRay& ray, shade::SampleSum& sum,
                                 std::vector<walk::TracedRay>& next) const {
    sum.bands = no_values(kHole, is_hole(ray));
    switch (cell_step_at(ray, m_view.scene.analysis.surface)) {
        case CellStep::kMeasure: send_to_neighbours(ray, sum, next); break;
        case CellStep::kDescend: next.push_back(below(ray)); break;
        case CellStep::kNothing: break;
    }
}

void EnergyEvaluator::send_to_neighbours(const walk::TracedRay& ray, shade::SampleSum& sum,
                                         std::vector<walk::TracedRay>& next) const {
    Heights heights;
    heights.sums.add(0, 0, 0);
    heights.top = static_cast<float>(top_of(ray.hit));
    heights.level = ray.hit.level;
    heights.waiting = kNeighbours - 1;
    heights.material = static_cast<float>(ray.hit.attr.material);
    keep(heights, sum.bands);
    const double above = m_view.camera.position().y;
    for (std::uint32_t place = 0; place < kNeighbours; ++place) {
        if (place == kOfCell)
            continue;
        core::Ray down = ray.ray;
        down.origin = {down.origin.x + east_of(place) * m_spacing, above,
                       down.origin.z + south_of(place) * m_spacing};
        walk::TracedRay out = cell_ray(down, ray.sample);
        out.state = core::RayState(out.ray);
        // Beyond the world there is no neighbour.
        if (!out.state.enter(m_view.cut.entry_bounds()))
            out.end = walk::WalkEnd::kMiss;
        out.stream = place;
        next.push_back(out);
    }
}

void EnergyEvaluator::shade_neighbour(const walk::TracedRay& ray, shade::SampleSum& sum,
                                      std::vector<walk::TracedRay>& next) const {
    const CellStep step = cell_step_at(ray, m_view.scene.analysis.surface);
    if (step == CellStep::kDescend) {
        next.push_back(below(ray));
        return;
    }
    auto heights = memory_of<Heights>(sum.bands);
    const int east = east_of(ray.stream);
    const int south = south_of(ray.stream);
    const int level = static_cast<int>(heights.level);
    const double voxel = det::exp2_int(level);
    if (step == CellStep::kMeasure) {
        const auto height = static_cast<float>(top_of(ray.hit)) - heights.top;
        const double distance = std::sqrt(east * east + south * south) * m_spacing;
        if (is_same_surface(distance, static_cast<double>(height), voxel))
            heights.sums.add(east, south, height);
    }
    heights.waiting -= 1;
    keep(heights, sum.bands);
    if (heights.waiting > 0)
        return;
    const CellPlane plane = plane_through(heights.sums, m_spacing, voxel);
    const core::Vec3 normal = plane.normal();
    Gathered gathered;
    gathered.east = static_cast<float>(normal.x);
    gathered.up = static_cast<float>(normal.y);
    gathered.south = static_cast<float>(normal.z);
    gathered.material = heights.material;
    keep(gathered, sum.bands);
    const core::Vec3 from{ray.ray.origin.x - east * m_spacing,
                          static_cast<double>(heights.top) + plane.lift,
                          ray.ray.origin.z - south * m_spacing};
    send_to_light({from, level, ray.sample}, 0, sum, next);
}

std::size_t EnergyEvaluator::directions() const noexcept {
    return m_view.energy.sun.size() + m_view.energy.sky.size();
}

core::Vec3 EnergyEvaluator::direction(std::size_t index) const noexcept {
    const std::size_t suns = m_view.energy.sun.size();
    return index < suns ? m_view.energy.sun[index].to : m_view.energy.sky[index - suns];
}

void EnergyEvaluator::send_to_light(const Start& start, std::size_t first, shade::SampleSum& sum,
                                    std::vector<walk::TracedRay>& next) const {
    const auto edge = static_cast<float>(det::exp2_int(start.level));
    const core::VoxelCoord voxel = voxel_at(start.at, edge);
    const std::size_t end = chunk_end(first, directions());
    auto gathered = memory_of<Gathered>(sum.bands);
    gathered.waiting = static_cast<float>(end - first);
    keep(gathered, sum.bands);
    for (std::size_t i = first; i < end; ++i) {
        walk::TracedRay& out = next.emplace_back();
        out.ray = {start.at, direction(i)};
        out.state = core::RayState(out.ray);
        out.state.start_in(voxel, start.level);
        // For the rays that follow it: the edge of the voxel from which it comes.
        out.footprint = edge;
        out.sample = start.sample;
        out.stream = static_cast<std::uint32_t>(i);
        out.kind = walk::RayKind::kShadow;
    }
}

bool EnergyEvaluator::sends_through_crowns(const walk::TracedRay& ray,
                                           std::vector<walk::TracedRay>& next) const {
    // A walk passes one material: crowns of more layers than this are as dark as walls.
    constexpr std::uint8_t kMaxWalks = 32;
    const bool is_first = ray.depth == 0;
    if (!m_crowns_shine || ray.end != walk::WalkEnd::kHit || ray.depth == kMaxWalks ||
        (!is_first && !is_crown(ray.hit.attr.material)))
        return false;
    walk::TracedRay out = ray;
    out.state = core::RayState(out.ray);
    if (is_first) {
        // What has blocked it is not known, so it starts again.
        out.state.start_in(voxel_at(ray.ray.origin, ray.footprint), level_of(ray.footprint));
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

void EnergyEvaluator::shade_light(const walk::TracedRay& ray, shade::SampleSum& sum,
                                  std::vector<walk::TracedRay>& next) const {
    if (sends_through_crowns(ray, next))
        return;
    const bool is_free = ray.end != walk::WalkEnd::kHit;
    const bool has_passed = ray.depth > 0;
    auto gathered = memory_of<Gathered>(sum.bands);
    const core::Vec3 to = ray.ray.direction;
    const double cosine = std::max(core::dot(normal_of(gathered), to), 0.0);
    const std::size_t suns = m_view.energy.sun.size();
    if (ray.stream < suns) {
        const solar::LightDirection& light = m_view.energy.sun[ray.stream];
        const double share = has_passed ? light.through_crowns : 1;
        if (is_free) {
            gathered.beam += static_cast<float>(light.beam * share * cosine);
            gathered.around_sun += static_cast<float>(light.around_sun * share * cosine);
            gathered.level += static_cast<float>((light.beam + light.around_sun) * share * to.y);
            gathered.sun_hours +=
                cosine > 0 && !has_passed ? static_cast<float>(light.hours) : 0.0F;
        }
    } else {
        const auto part = static_cast<float>(cosine);
        const auto level = static_cast<float>(to.y);
        const float low = to.y < solar::kHorizonSine ? part : 0.0F;
        const double share = has_passed ? m_view.energy.through_crowns : 1;
        const float free = is_free ? static_cast<float>(share) : 0.0F;
        gathered.sky += part;
        gathered.free_sky += part * free;
        gathered.level_sky += level;
        gathered.free_level_sky += level * free;
        gathered.horizon += low;
        gathered.free_horizon += low * free;
    }
    gathered.waiting -= 1;
    keep(gathered, sum.bands);
    if (gathered.waiting > 0)
        return;
    const std::size_t end = chunk_end(ray.stream / kChunkRays * kChunkRays, directions());
    if (end == directions())
        sum.bands = result_of(sum.bands);
    else
        send_to_light({ray.ray.origin, level_of(ray.footprint), ray.sample}, end, sum, next);
}

core::Bands EnergyEvaluator::result_of(const core::Bands& memory) const noexcept {
    const auto gathered = memory_of<Gathered>(memory);
    const solar::Energy& energy = m_view.energy;
    const core::Vec3 normal = normal_of(gathered);
    const double upward = normal.y;
    const double sine = std::sqrt(normal.x * normal.x + normal.z * normal.z);
    // The part of the plane's light that an even sky sends: exact where nothing is in the way.
    const double sky_view = (1 + upward) / 2 * share(gathered.free_sky, gathered.sky);
    const double diffuse =
        std::max(0.0, energy.isotropic * sky_view + static_cast<double>(gathered.around_sun) +
                          energy.horizon * sine * share(gathered.free_horizon, gathered.horizon));
    const double level = static_cast<double>(gathered.level) +
                         energy.isotropic * share(gathered.free_level_sky, gathered.level_sky);
    // What is not sky is lit like a level surface here, and reflects evenly.
    const double reflected = m_view.scene.analysis.albedo * level * (1 - sky_view);
    const auto beam = static_cast<double>(gathered.beam);
    constexpr double kDegPerRad = 180 / det::kPi;
    core::Bands out{};
    at(out, EnergyBand::kTotal) = static_cast<float>(beam + diffuse + reflected);
    at(out, EnergyBand::kBeam) = gathered.beam;
    at(out, EnergyBand::kDiffuse) = static_cast<float>(diffuse);
    at(out, EnergyBand::kReflected) = static_cast<float>(reflected);
    at(out, EnergyBand::kSlope) = static_cast<float>(det::atan2(sine, upward) * kDegPerRad);
    const double azimuth = det::atan2(normal.x, 0 - normal.z) * kDegPerRad;
    at(out, EnergyBand::kAspect) =
        sine > 0 ? static_cast<float>(azimuth < 0 ? azimuth + 360 : azimuth) : core::kNoData;
    at(out, EnergyBand::kSunHours) = gathered.sun_hours;
    at(out, EnergyBand::kMaterial) = gathered.material;
    return out;
}

}  // namespace terravox::analyse
