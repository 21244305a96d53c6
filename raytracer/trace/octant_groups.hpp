#pragma once

#include <array>

#include "raytracer/trace/traced_ray.hpp"
#include "raytracer/walk/packet_walk.hpp"

namespace terravox {

/// Rays that go every way from places that lie together: what matt faces send out, and mirrors. Those of one octant and major axis fill packets.
/// One for each thread.
class OctantGroups {
public:
    explicit OctantGroups(PacketWalk& packets) noexcept : m_packets(packets) {}

    /// Whether it can go in a packet.
    [[nodiscard]] static bool accepts(const TracedRay& ray) noexcept { return ray.stop == StopAt::kSolid && RayPacket::accepts(ray.state); }
    /// Walks it sooner or later, until finish() at the latest: sets `end`, and `hit` with it, or leaves it where RayWalk has to go on.
    /// @param ray stays where it is until then; accepts()
    void add(TracedRay& ray);
    void finish();

private:
    static constexpr std::size_t kWays = 8 * 3;
    struct Group {
        RayPacket packet;
        TracedRay* rays[RayPacket::kLanes] = {};
    };
    void walk(Group& group, bool asks);
    PacketWalk& m_packets;
    std::array<std::array<Group, kWays>, 2> m_groups;  ///< of rays that want to know what they hit, and of those that only ask
};

}  // namespace terravox
