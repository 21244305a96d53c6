#include "raytracer/core/trace/fan_tracer.hpp"

#include <algorithm>

namespace terravox::trace {
namespace {

// Fewer rays are walked in packets faster than a shaft around them is marched.
constexpr std::size_t kSmallest = 64;

}  // namespace

// What is known of a large group saves the small ones the same distance.
std::uint64_t ShadowGroups::trace(std::span<const ShadowRay> rays, std::size_t size,
                                  std::optional<std::int32_t> known) {
    constexpr std::size_t kParts = 4;
    walk::Shaft shaft(m_sun, m_radius_rad);
    for (const ShadowRay& ray : rays)
        shaft.add(ray.origin, *ray.state);
    const std::int32_t free_from = m_shafts.free_from(shaft, known);
    std::uint64_t spared = 0;
    if (size > kSmallest) {
        const std::size_t part = size / kParts;
        for (std::size_t first = 0; first < rays.size(); first += part)
            spared +=
                trace(rays.subspan(first, std::min(part, rays.size() - first)), part, free_from);
        return spared;
    }
    for (const ShadowRay& ray : rays) {
        if (walk::ShaftMarch::is_free(shaft, *ray.state, free_from)) {
            *ray.end = walk::WalkEnd::kMiss;
            ++spared;
        } else if (m_packets != nullptr && walk::RayPacket::accepts(*ray.state)) {
            add(ray, shaft.axis(), free_from);
        }
    }
    return spared;
}

// Where shafts have freed many, packets are filled up with the next ones: each lane walks for
// itself.
void ShadowGroups::add(const ShadowRay& ray, int axis, std::int32_t free_from) {
    if (m_packet.count == walk::RayPacket::kLanes || !m_packet.fits(*ray.state))
        walk();
    m_lanes[m_packet.count] = &ray;
    m_packet.free_axis = axis;
    m_packet.free_from[m_packet.count] = free_from;
    m_packet.add(*ray.state);
}

void ShadowGroups::walk() {
    if (m_packet.count == 0)
        return;
    const walk::PacketWalk::Ends ends = m_packets->any_hits(m_packet, (1u << m_packet.count) - 1);
    for (int i = 0; i < m_packet.count; ++i) {
        if ((ends.hit >> i & 1) != 0)
            *m_lanes[i]->end = walk::WalkEnd::kHit;
        else if ((ends.missed >> i & 1) != 0)
            *m_lanes[i]->end = walk::WalkEnd::kMiss;
        else
            m_packet.update(i, *m_lanes[i]->state);
    }
    m_packet = {};
}

namespace {

// Which ray of which fan a ray is that was appended to the wave is kept in its stream.
constexpr std::uint32_t to_stream(std::uint32_t fan, std::size_t direction) noexcept {
    return fan * static_cast<std::uint32_t>(walk::kFanRays) + static_cast<std::uint32_t>(direction);
}

walk::FanMask to_bit(std::size_t direction) noexcept {
    return static_cast<walk::FanMask>(1U << direction);
}

}  // namespace

void FanTracer::trace(TracerTools& tools, std::vector<walk::TracedRay>& rays,
                      tiles::TraceCounts& counts) {
    m_first_single = rays.size();
    m_ends.assign(rays.size(), {});
    sort_by_stream(rays);
    for (std::size_t first = 0; first < m_by_stream.size();) {
        const std::uint32_t stream = rays[m_by_stream[first]].stream;
        std::size_t end = first;
        while (end < m_by_stream.size() && rays[m_by_stream[end]].stream == stream)
            ++end;
        const walk::FanDirections directions = tools.shading->directions(stream);
        while (first < end) {
            const std::size_t size = std::min(ShadowGroups::kMax, end - first);
            take_group(rays, std::span(m_by_stream).subspan(first, size));
            trace_group(tools, rays, directions, counts);
            first += size;
        }
    }
}

// Counts the fans of each stream, and puts them in its place: fans of one stream stay in order.
void FanTracer::sort_by_stream(std::span<const walk::TracedRay> rays) {
    m_by_stream.clear();
    std::uint32_t low = std::numeric_limits<std::uint32_t>::max();
    std::uint32_t high = 0;
    std::uint32_t count = 0;
    for (const walk::TracedRay& ray : rays) {
        if (!ray.is_fan())
            continue;
        low = std::min(low, ray.stream);
        high = std::max(high, ray.stream);
        ++count;
    }
    if (count == 0)
        return;
    m_stream_end.assign(std::size_t{high} - low + 1, 0);
    for (const walk::TracedRay& ray : rays)
        if (ray.is_fan())
            ++m_stream_end[ray.stream - low];
    std::uint32_t before = 0;
    for (std::uint32_t& end : m_stream_end)
        before = end = before + end;
    m_by_stream.resize(count);
    for (auto i = static_cast<std::uint32_t>(rays.size()); i-- > 0;)
        if (rays[i].is_fan())
            m_by_stream[--m_stream_end[rays[i].stream - low]] = i;
}

void FanTracer::take_group(std::span<const walk::TracedRay> rays,
                           std::span<const std::uint32_t> indices) {
    m_group.clear();
    for (const std::uint32_t index : indices) {
        const walk::TracedRay& fan = rays[index];
        const auto& voxel = fan.state.voxel;
        m_group.push_back(
            {fan.ray.origin, {voxel[0], voxel[1], voxel[2]}, index, fan.fan_mask, fan.state.level});
    }
}

void FanTracer::trace_group(TracerTools& tools, std::vector<walk::TracedRay>& rays,
                            const walk::FanDirections& directions, tiles::TraceCounts& counts) {
    for (std::size_t d = 0; d < directions.count; ++d) {
        start_rays(d, directions.to[d]);
        // Shafts and packets know no end of a ray.
        if (rays[m_group.front().index].t_max == core::kFar) {
            ShadowGroups groups(tools.shafts, tools.packets ? &*tools.packets : nullptr,
                                directions.to[d], 0);
            counts.spared += groups.trace(m_shadows);
        }
        for (const Started& started : m_started) {
            if (started.end == walk::WalkEnd::kHit)
                m_ends[started.index].blocked |= to_bit(d);
            if (started.end != walk::WalkEnd::kWaits)
                continue;
            walk::TracedRay& single = rays.emplace_back(rays[started.index]);
            single.fan_mask = 0;
            single.ray.direction = directions.to[d];
            single.state = started.state;
            single.stream = to_stream(started.index, d);
        }
    }
}

void FanTracer::start_rays(std::size_t direction, const core::Vec3& to) {
    m_started.clear();
    m_started.reserve(m_group.size());  // pointers to them are kept
    m_shadows.clear();
    m_model = core::RayState({{}, to});
    for (const Member& fan : m_group) {
        if (!walk::has(fan.mask, direction))
            continue;
        m_model.change_scale(fan.level);
        // Set where it lies: to copy a ray right after it is written stalls the processor.
        Started& ray = m_started.emplace_back(fan.index, walk::WalkEnd::kWaits, m_model);
        ray.state.restart_in(fan.voxel, fan.from);
        m_shadows.push_back({fan.from, &ray.state, &ray.end});
    }
}

void FanTracer::take_singles(std::vector<walk::TracedRay>& rays, tiles::TraceCounts& counts) {
    if (m_first_single >= rays.size())
        return;
    for (const walk::TracedRay& ray : std::span(rays).subspan(m_first_single)) {
        if (ray.end != walk::WalkEnd::kHit)
            continue;
        walk::FanEnds& ends = m_ends[ray.stream / walk::kFanRays];
        const walk::FanMask bit = to_bit(ray.stream % walk::kFanRays);
        ends.blocked |= bit;
        if (ray.hit.hole) {
            ends.holes |= bit;
            ++counts.hole_rays;
        }
    }
    rays.resize(m_first_single);
}

}  // namespace terravox::trace
