#include "raytracer/trace/octant_groups.hpp"

#include <cmath>

namespace terravox {
namespace {

int major_axis(const RayState& ray) noexcept {
    const double x = std::abs(ray.direction[0]), y = std::abs(ray.direction[1]), z = std::abs(ray.direction[2]);
    return x >= y ? (x >= z ? 0 : 2) : (y >= z ? 1 : 2);
}

std::size_t way_of(const RayState& ray, int axis) noexcept {
    const int octant = (ray.forward[0] ? 1 : 0) | (ray.forward[1] ? 2 : 0) | (ray.forward[2] ? 4 : 0);
    return static_cast<std::size_t>(3 * octant + axis);
}

/// A plane that the ray reaches after t_max.
double plane_after(const RayState& ray, int axis, double t_max) noexcept {
    constexpr double kRoom_voxels = 2, kFarAway = 1e9;
    const double at = (ray.origin[axis] + ray.direction[axis] * t_max) * power_of_two(ray.level), room = kRoom_voxels * power_of_two(ray.level);
    return std::clamp(std::floor(ray.forward[axis] ? at + room : at - room), -kFarAway, kFarAway);
}

}  // namespace

void OctantGroups::add(TracedRay& ray) {
    const bool asks = ray.only_blocked();
    const int axis = major_axis(ray.state);
    Group& group = m_groups[asks ? 1 : 0][way_of(ray.state, axis)];
    RayPacket& packet = group.packet;
    if (packet.count == RayPacket::kLanes || !packet.fits(ray.state)) walk(group, asks);
    packet.free_axis = axis, packet.free_from[packet.count] = plane_after(ray.state, axis, ray.t_max);
    group.rays[packet.count] = &ray;
    packet.add(ray.state);
}

void OctantGroups::finish() {
    for (std::size_t asks = 0; asks < m_groups.size(); ++asks)
        for (Group& group : m_groups[asks]) walk(group, asks != 0);
}

void OctantGroups::walk(Group& group, bool asks) {
    RayPacket& packet = group.packet;
    if (packet.count == 0) return;
    const std::uint32_t lanes = (1u << packet.count) - 1;
    Hit hits[RayPacket::kLanes];
    const PacketWalk::Ends ends = asks ? m_packets.any_hits(packet, lanes) : m_packets.first_hits(packet, lanes, hits);
    for (int i = 0; i < packet.count; ++i) {
        TracedRay& ray = *group.rays[i];
        if ((ends.missed >> i & 1) != 0 || ((ends.hit >> i & 1) != 0 && packet.t[i] > ray.t_max)) ray.end = WalkEnd::kMiss;
        else if ((ends.hit >> i & 1) == 0) packet.update(i, ray.state);
        else {
            ray.end = WalkEnd::kHit;
            if (!asks) ray.hit = hits[i];
        }
    }
    packet = {};
}

}  // namespace terravox
