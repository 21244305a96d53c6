#include "raytracer/trace/shadow_groups.hpp"

#include <algorithm>

namespace terravox {

// What is known of a large group spares the small ones the same way.
std::uint64_t ShadowGroups::trace(std::span<const ShadowRay> rays, std::size_t size, std::optional<std::int32_t> known) {
    constexpr std::size_t kParts = 4;
    Shaft shaft(m_sun, m_radius_rad);
    for (const ShadowRay& ray : rays) shaft.add(ray.origin, *ray.state);
    const std::int32_t free_from = m_shafts.free_from(shaft, known);
    std::uint64_t spared = 0;
    if (size > RayPacket::kLanes) {
        const std::size_t part = size / kParts;
        for (std::size_t first = 0; first < rays.size(); first += part) spared += trace(rays.subspan(first, std::min(part, rays.size() - first)), part, free_from);
        return spared;
    }
    for (const ShadowRay& ray : rays) {
        if (!ShaftMarch::is_free(shaft, *ray.state, free_from)) continue;
        *ray.end = WalkEnd::kMiss;
        ++spared;
    }
    if (m_packets != nullptr) walk(rays);
    return spared;
}

void ShadowGroups::walk(std::span<const ShadowRay> rays) {
    RayPacket packet;
    const ShadowRay* lanes[RayPacket::kLanes];
    for (const ShadowRay& ray : rays)
        if (*ray.end == WalkEnd::kWaits && RayPacket::accepts(*ray.state) && packet.fits(*ray.state)) {
            lanes[packet.count] = &ray;
            packet.add(*ray.state);
        }
    if (packet.count == 0) return;
    const PacketWalk::Ends ends = m_packets->any_hits(packet, (1u << packet.count) - 1);
    for (int i = 0; i < packet.count; ++i) {
        if ((ends.hit >> i & 1) != 0) *lanes[i]->end = WalkEnd::kHit;
        else if ((ends.missed >> i & 1) != 0) *lanes[i]->end = WalkEnd::kMiss;
        else packet.update(i, *lanes[i]->state);
    }
}

}  // namespace terravox
