#include "raytracer/core/trace/shadow_groups.hpp"

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

}  // namespace terravox::trace
