#include "raytracer/core/trace/ray_wave.hpp"

#include <algorithm>
#include <bit>
#include <optional>

namespace terravox::trace {
namespace {

static_assert(tiles::TraceCounts::kKinds == walk::kRayKinds);

// Returns false if a box is missing.
bool walk_ray(TracerTools& tools, std::span<const shade::SampleSum> samples, walk::TracedRay& ray,
              voxel::BoxKey& missing) {
    if (ray.end == walk::WalkEnd::kWaits) {
        ray.end = ray.only_blocked()
                      ? tools.walk.any_hit(ray.state, ray.t_max, tools.occluder)
                      : tools.walk.first_hit(ray.state, ray.stop, ray.t_max, ray.hit);
        if (ray.end == walk::WalkEnd::kWaits) {
            missing = tools.walk.missing();
            return false;
        }
        if (ray.only_blocked())
            ray.hit.hole = ray.end == walk::WalkEnd::kHit && tools.occluder.hole;
    }
    if (tools.shading->needs_surroundings(ray) && !tools.surroundings.around(ray.hit, ray.around)) {
        missing = tools.surroundings.missing();
        return false;
    }
    if (tools.shading->needs_lamp(ray) &&
        !tools.lamps.choose(ray.hit, ray.ray.origin + ray.ray.direction * ray.hit.t,
                            tools.shading->lamp_number(ray, samples[ray.sample]), ray.lamp)) {
        missing = tools.lamps.missing();
        return false;
    }
    return true;
}

bool needs_voxels_around(const TracerTools& tools, const walk::TracedRay& ray) {
    return tools.shading->needs_surroundings(ray) || tools.shading->needs_lamp(ray);
}

bool is_pending(const TracerTools& tools, const walk::TracedRay& ray) {
    return !ray.is_fan() && (ray.end == walk::WalkEnd::kWaits || needs_voxels_around(tools, ray));
}

}  // namespace

void RayWave::clear() {
    m_rays.clear();
    m_fans.clear();
    m_pending.clear();
    m_parked.clear();
    m_missing.clear();
    m_arrived.clear();
}

std::span<walk::TracedRay> RayWave::begin(std::size_t count) {
    m_rays.clear();
    m_rays.resize(count);
    m_fans.clear();
    return m_rays;
}

void RayWave::on_box_loaded(const voxel::BoxKey& key) {
    const auto found = m_parked.find(key);
    if (found == m_parked.end())
        return;
    m_arrived.push_back(key);
    m_pending.insert(m_pending.end(), found->second.begin(), found->second.end());
    m_parked.erase(found);
}

bool RayWave::walk(TracerTools& tools, std::span<const shade::SampleSum> samples,
                   const thread::StopCondition& stop, tiles::TraceCounts& counts) {
    std::size_t done = 0;
    while (done < m_pending.size()) {
        const std::uint32_t index = m_pending[done++];
        if (voxel::BoxKey missing; !walk_ray(tools, samples, m_rays[index], missing)) {
            ++counts.parked;
            auto& waiting = m_parked[missing];
            if (waiting.empty())
                m_missing.push_back(missing);
            waiting.push_back(index);
        }
        if (stop.is_met())
            break;
    }
    m_pending.erase(m_pending.begin(), m_pending.begin() + static_cast<std::ptrdiff_t>(done));
    if (m_pending.empty())
        read_arrived(tools);
    return m_pending.empty() && m_parked.empty();
}

// Loaders make no room of a box until it has been read. The thread that goes on may know already
// what a ray wanted of it.
void RayWave::read_arrived(TracerTools& tools) {
    for (const voxel::BoxKey& key : m_arrived)
        (void)tools.reader.get(key);
    m_arrived.clear();
}

void RayWave::shade(TracerTools& tools, std::span<shade::SampleSum> samples, StageClock& clock,
                    tiles::TraceCounts& counts) {
    m_next.clear();
    m_fans.take_singles(m_rays, counts);
    for (std::size_t i = 0; i < m_rays.size(); ++i) {
        const walk::TracedRay& ray = m_rays[i];
        if (ray.is_fan()) {
            tools.shading->shade_fan(ray, m_fans.ends(i), samples[ray.sample], m_next);
            continue;
        }
        if (ray.end == walk::WalkEnd::kHit && ray.hit.hole)
            ++counts.hole_rays;
        tools.shading->shade(ray, samples[ray.sample], m_next);
    }
    m_rays.swap(m_next);
    for (const walk::TracedRay& ray : m_rays)
        counts.rays[static_cast<std::size_t>(ray.kind)] +=
            !ray.is_fan() ? 1 : static_cast<std::uint64_t>(std::popcount(ray.fan_mask));
    clock.lap(tiles::TraceStage::kShading, counts);
    if (tools.view.measuring)
        m_fans.trace(tools, m_rays, counts);
    else
        trace_shadow_groups(tools, counts);
    clock.lap(tiles::TraceStage::kSun, counts);
    trace_scattered(tools);
    clock.lap(tiles::TraceStage::kScattered, counts);
    for (std::uint32_t i = 0; i < m_rays.size(); ++i)
        if (is_pending(tools, m_rays[i]))
            m_pending.push_back(i);
}

// Shadow rays that follow each other in a wave come from neighbouring pixels.
void RayWave::trace_shadow_groups(TracerTools& tools, tiles::TraceCounts& counts) {
    ShadowGroups groups(tools.shafts, tools.packets ? &*tools.packets : nullptr,
                        tools.view.sky.to_sun(), tools.view.sky.sun_radius_rad());
    m_shadows.clear();
    for (walk::TracedRay& ray : m_rays)
        if (ray.kind == walk::RayKind::kShadow && ray.stop == walk::StopAt::kSolid &&
            ray.state.t == 0)
            m_shadows.push_back({ray.ray.origin, &ray.state, &ray.end});
    for (std::size_t first = 0; first < m_shadows.size(); first += ShadowGroups::kMax)
        counts.spared += groups.trace(std::span(m_shadows).subspan(
            first, std::min(ShadowGroups::kMax, m_shadows.size() - first)));
    // Where it matters what stops a ray, it is walked once more, alone.
    for (walk::TracedRay& ray : m_rays)
        if (ray.leaves && ray.end == walk::WalkEnd::kHit)
            ray.end = walk::WalkEnd::kWaits;
}

// Rays that matt faces send out, mirrored rays, and shadow rays among leaves.
void RayWave::trace_scattered(TracerTools& tools) {
    if (!tools.lanes)
        return;
    m_scattered.clear();
    for (walk::TracedRay& ray : m_rays)
        if (!ray.is_fan() && ray.end == walk::WalkEnd::kWaits && ray.stop == walk::StopAt::kSolid)
            m_scattered.push_back(
                {&ray.state, &ray.end, ray.t_max, ray.only_blocked() ? nullptr : &ray.hit});
    tools.lanes->trace(m_scattered);
}

void PrimaryRays::make(std::uint32_t sample) {
    m_rays = m_wave.begin(m_active.size());
    const auto size = static_cast<std::uint32_t>(m_active.size());
    for (std::uint32_t i = 0; i < size; ++i) {
        const TilePixel& pixel = m_pixels[m_active[i]];
        m_samples[i].numbers =
            shade::Sampler(pixel.x, pixel.y, sample, m_tools.view.scene.quality.seed);
    }
    std::uint32_t end = 0;
    for (std::uint32_t first = 0; first < size; first = end) {
        const PixelBlock& block = *m_pixels[m_active[first]].block;
        end = first + 1;
        while (end < size && m_pixels[m_active[end]].block == &block)
            ++end;
        if (m_tools.packets && block.start.kind == walk::BeamStart::Kind::kPlane) {
            make_packet(block, first, end - first);
            continue;
        }
        for (std::uint32_t i = first; i < end; ++i)
            make_single(i);
    }
    m_counts.rays[static_cast<std::size_t>(walk::RayKind::kPrimary)] += m_rays.size();
}

std::pair<double, double> PrimaryRays::picture_point(std::uint32_t place) const noexcept {
    const TilePixel& pixel = m_pixels[m_active[place]];
    if (m_tools.view.scene.quality.samples == 1)
        return {pixel.x + 0.5, pixel.y + 0.5};
    const shade::Sampler::Pair at = m_samples[place].numbers.in_pixel();
    return {pixel.x + at.u, pixel.y + at.v};
}

void PrimaryRays::make_single(std::uint32_t place) {
    const shade::View& view = m_tools.view;
    const walk::BeamStart& start = m_pixels[m_active[place]].block->start;
    const auto [px, py] = picture_point(place);
    const shade::Sampler::Pair lens = view.camera.has_lens() ? m_samples[place].numbers.on_lens()
                                                             : shade::Sampler::Pair{0.5, 0.5};
    const std::optional<core::Ray> sent = view.camera.ray(px, py, lens.u, lens.v);
    walk::TracedRay& ray = m_rays[place];
    ray = m_tools.shading->primary(sent ? *sent : view.camera.ray(px, py), place);
    if (!sent) {
        // Nothing is seen there: black, and no share of anything.
        ray.end = walk::WalkEnd::kMiss;
        ray.weight = {};
        return;
    }
    if (start.kind != walk::BeamStart::Kind::kMiss) {
        ray.state = core::RayState(ray.ray);
        if (start.place(ray.state, view.cut)) {
            m_wave.add_pending(place);
            return;
        }
    }
    ray.end = walk::WalkEnd::kMiss;
    ++m_counts.spared;
}

void PrimaryRays::make_packet(const PixelBlock& block, std::uint32_t first, std::uint32_t count) {
    walk::PrimaryLanes lanes =
        walk::primary_lanes(m_tools.view.camera, block.start, m_tools.view.cut);
    for (std::uint32_t i = 0; i < walk::RayPacket::kLanes; ++i) {
        const auto [px, py] = picture_point(first + (i < count ? i : 0));
        lanes.px[i] = px;
        lanes.py[i] = py;
    }
    walk::RayPacket packet;
    walk::Hit hits[walk::RayPacket::kLanes];
    const std::uint32_t placed = walk::packet_steps()->primary(packet, lanes) & ((1U << count) - 1);
    for (std::uint32_t i = 0; i < count; ++i) {
        if ((placed >> i & 1) == 0) {
            make_single(first + i);
            continue;
        }
        const core::Vec3 direction = {packet.direction[0][i], packet.direction[1][i],
                                      packet.direction[2][i]};
        m_rays[first + i] = m_tools.shading->primary({lanes.camera.position, direction}, first + i);
    }
    const walk::PacketWalk::Ends ends = m_tools.packets->first_hits(packet, placed, hits);
    for (std::uint32_t i = 0; i < count; ++i) {
        if ((placed >> i & 1) == 0)
            continue;
        walk::TracedRay& ray = m_rays[first + i];
        if ((ends.missed >> i & 1) != 0) {
            ray.end = walk::WalkEnd::kMiss;
            continue;
        }
        m_wave.add_pending(first + i);
        if ((ends.hit >> i & 1) != 0) {
            ray.end = walk::WalkEnd::kHit;
            ray.hit = hits[i];
        } else {
            ray.state = core::RayState(ray.ray);
            packet.update(static_cast<int>(i), ray.state);
        }
    }
}

}  // namespace terravox::trace
