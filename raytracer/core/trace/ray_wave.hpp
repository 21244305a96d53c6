#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "common/thread/stop_condition.hpp"
#include "common/voxel/box.hpp"
#include "raytracer/core/tiles/trace_counts.hpp"
#include "raytracer/core/trace/fan_tracer.hpp"
#include "raytracer/core/trace/shadow_groups.hpp"
#include "raytracer/core/trace/stage_clock.hpp"
#include "raytracer/core/trace/tracer_tools.hpp"

namespace terravox::trace {

/// Rays that are walked together and then shaded in order, which makes the next wave. A ray whose
/// box is missing is parked while the others continue. Used by one thread at a time.
class RayWave {
public:
    /// Discards all rays, including parked ones.
    void clear();
    /// Begins a wave of `count` rays, which the caller fills.
    [[nodiscard]] std::span<walk::TracedRay> begin(std::size_t count);
    /// Makes a ray of begin() pending; walk() walks pending rays only.
    void add_pending(std::uint32_t index) { m_pending.push_back(index); }
    /// Walks pending rays until none is left or `stop`, which is checked after each ray, requests
    /// an end.
    /// @param samples that the rays belong to, by TracedRay::sample
    /// @return whether all are walked and none is parked
    [[nodiscard]] bool walk(TracerTools& tools, std::span<const shade::SampleSum> samples,
                            const thread::StopCondition& stop, tiles::TraceCounts& counts);
    /// Shades the wave, all of whose rays must have been walked. The rays that this makes become
    /// the wave; fans, those towards the sun, and those that scatter are traced here as far as
    /// groups can do it.
    /// @param samples that the rays belong to, by TracedRay::sample
    void shade(TracerTools& tools, std::span<shade::SampleSum> samples, StageClock& clock,
               tiles::TraceCounts& counts);
    [[nodiscard]] bool empty() const noexcept { return m_rays.empty(); }
    /// Whether walk() has nothing to do until on_box_loaded().
    [[nodiscard]] bool waits() const noexcept { return m_pending.empty() && !m_parked.empty(); }
    /// Boxes that rays have begun to wait for since the last call.
    [[nodiscard]] std::vector<voxel::BoxKey> take_missing() { return std::exchange(m_missing, {}); }
    /// Makes the rays that wait for this box pending again.
    void on_box_loaded(const voxel::BoxKey& key);

private:
    void read_arrived(TracerTools& tools);
    void trace_shadow_groups(TracerTools& tools, tiles::TraceCounts& counts);
    void trace_scattered(TracerTools& tools);

    std::vector<walk::TracedRay> m_rays;
    std::vector<walk::TracedRay> m_next;
    FanTracer m_fans;
    std::vector<ShadowRay> m_shadows;
    std::vector<walk::LaneRay> m_scattered;
    std::vector<std::uint32_t> m_pending;  ///< indices into m_rays
    /// Indices into m_rays by the box that they wait for.
    std::unordered_map<voxel::BoxKey, std::vector<std::uint32_t>, voxel::BoxKeyHash> m_parked;
    std::vector<voxel::BoxKey> m_missing;
    std::vector<voxel::BoxKey> m_arrived;  ///< that rays have waited for, and that may be unread
};

}  // namespace terravox::trace
