#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "raytracer/core/tiles/tile.hpp"
#include "raytracer/core/trace/tracer_tools.hpp"
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

/// Traces the fans of a wave (walk/traced_ray.hpp): fans of one stream direction by direction, in
/// groups of neighbours. Used by one thread at a time.
class FanTracer {
public:
    /// Forgets a wave that is discarded.
    void clear() noexcept { m_first_single = kNone; }
    /// Traces the fans among the rays of a wave as far as groups can do it. A ray whose end is not
    /// known then is appended to the wave, which walks it.
    void trace(TracerTools& tools, std::vector<walk::TracedRay>& rays, tiles::TraceCounts& counts);
    /// Takes the rays that trace() has appended out of the wave, all of whose rays must have been
    /// walked.
    void take_singles(std::vector<walk::TracedRay>& rays, tiles::TraceCounts& counts);
    /// What became of a fan, after take_singles().
    /// @param index of the fan in the wave
    [[nodiscard]] walk::FanEnds ends(std::size_t index) const noexcept { return m_ends[index]; }

private:
    static constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();

    void sort_by_stream(std::span<const walk::TracedRay> rays);
    /// @param indices at most ShadowGroups::kMax, into the wave, of fans of one stream
    void take_group(std::span<const walk::TracedRay> rays, std::span<const std::uint32_t> indices);
    /// Traces the rays of the group.
    void trace_group(TracerTools& tools, std::vector<walk::TracedRay>& rays,
                     const walk::FanDirections& directions, tiles::TraceCounts& counts);
    /// Places those of the group's rays that go in one direction.
    void start_rays(std::size_t direction, const core::Vec3& to);

    std::vector<walk::FanEnds> m_ends;        ///< by index into the wave; of fans only
    std::vector<std::uint32_t> m_by_stream;   ///< indices into the wave, of fans
    std::vector<std::uint32_t> m_stream_end;  ///< in m_by_stream, by stream
    std::size_t m_first_single = kNone;       ///< in the wave

    /// What is needed of a fan of the group: less than a line of the processor's cache.
    struct Member {
        core::Vec3 from;  ///< level-0 voxels
        core::VoxelCoord voxel;
        std::uint32_t index;  ///< into the wave
        walk::FanMask mask;
        std::int8_t level;
    };
    std::vector<Member> m_group;
    /// A ray of the group in one direction.
    struct Started {
        std::uint32_t index;  ///< of its fan in the wave
        walk::WalkEnd end;
        core::RayState state;
    };
    core::RayState m_model;  ///< of a direction, for all that start
    std::vector<Started> m_started;
    std::vector<ShadowRay> m_shadows;
};

}  // namespace terravox::trace
