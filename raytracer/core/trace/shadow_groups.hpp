#pragma once

#include <optional>
#include <span>

#include "raytracer/core/walk/packet_walk.hpp"
#include "raytracer/core/walk/shaft.hpp"

namespace terravox::trace {

/// A ray towards the sun, in the caller's array.
struct ShadowRay {
    core::Vec3 origin;      ///< level-0 voxels
    core::RayState* state;  ///< placed in the voxel that it starts in
    walk::WalkEnd* end;     ///< kWaits: not known yet
};

/// Answers shadow rays, towards points of the sun, that lie together: by shafts over 256 and 64 of
/// them, then in packets. Use one object per thread.
class ShadowGroups {
public:
    static constexpr std::size_t kMax = 256;
    /// @param packets null: shafts only
    ShadowGroups(walk::ShaftMarch& shafts, walk::PacketWalk* packets, core::Vec3 sun,
                 double sun_radius_rad) noexcept
        : m_shafts(shafts), m_packets(packets), m_sun(sun), m_radius_rad(sun_radius_rad) {}

    /// Sets `end` of the rays whose end is known. The others may have advanced part of their way
    /// and are left to RayWalk.
    /// @param rays at most kMax, neighbours next to each other
    /// @return number of rays that needed no step
    std::uint64_t trace(std::span<const ShadowRay> rays) {
        const std::uint64_t spared = trace(rays, kMax, std::nullopt);
        walk();
        return spared;
    }

private:
    std::uint64_t trace(std::span<const ShadowRay> rays, std::size_t size,
                        std::optional<std::int32_t> known);
    /// Adds a ray to the packet.
    /// @param free_from plane on `axis` from which on the ray is free
    void add(const ShadowRay& ray, int axis, std::int32_t free_from);
    void walk();
    walk::ShaftMarch& m_shafts;
    walk::PacketWalk* m_packets;
    core::Vec3 m_sun;
    double m_radius_rad;
    walk::RayPacket m_packet;  ///< rays that wait until it is full
    const ShadowRay* m_lanes[walk::RayPacket::kLanes] = {};
};

}  // namespace terravox::trace
