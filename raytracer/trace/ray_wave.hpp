#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "common/thread/stop_condition.hpp"
#include "common/voxel/box.hpp"
#include "raytracer/tiles/trace_counts.hpp"
#include "raytracer/trace/shadow_groups.hpp"
#include "raytracer/trace/stage_clock.hpp"
#include "raytracer/trace/tracer_tools.hpp"

namespace terravox::trace {

/// Rays that are walked together and then shaded in order, which makes the next wave. A ray whose
/// box is missing is parked while the others go on. Used by one thread at a time.
class RayWave {
public:
    /// Forgets all rays, those that are parked, too.
    void clear();
    /// Begins with so many rays, which are the caller's to fill.
    [[nodiscard]] std::span<walk::TracedRay> begin(std::size_t count);
    /// A ray of begin() is to be walked by walk(), which it is not otherwise.
    void add_pending(std::uint32_t index) { m_pending.push_back(index); }
    /// Walks pending rays until none is left or it is to stop, which it hears of after each ray.
    /// @return whether all are walked, and none is parked
    [[nodiscard]] bool walk(TracerTools& tools, const thread::StopCondition& stop,
                            tiles::TraceCounts& counts);
    /// Shades the wave, whose rays are walked all. The rays that this makes are the wave now; those
    /// towards the sun and those that scatter are traced as far as groups of them go.
    /// @param samples that the rays belong to, by TracedRay::sample
    void shade(TracerTools& tools, std::span<shade::SampleSum> samples, StageClock& clock,
               tiles::TraceCounts& counts);
    [[nodiscard]] bool empty() const noexcept { return m_rays.empty(); }
    /// Whether walk() has nothing to do before box_came().
    [[nodiscard]] bool waits() const noexcept { return m_pending.empty() && !m_parked.empty(); }
    /// Boxes that rays have begun to wait for since the last call.
    [[nodiscard]] std::vector<voxel::BoxKey> take_missing() { return std::exchange(m_missing, {}); }
    /// The rays that wait for this box are pending again.
    void box_came(const voxel::BoxKey& key);

private:
    void trace_shadow_groups(TracerTools& tools, tiles::TraceCounts& counts);
    void trace_scattered(TracerTools& tools);

    std::vector<walk::TracedRay> m_rays;
    std::vector<walk::TracedRay> m_next;
    std::vector<ShadowRay> m_shadows;
    std::vector<walk::LaneRay> m_scattered;
    std::vector<std::uint32_t> m_pending;  ///< indices of m_rays
    /// Indices of m_rays by the box that they wait for.
    std::unordered_map<voxel::BoxKey, std::vector<std::uint32_t>, voxel::BoxKeyHash> m_parked;
    std::vector<voxel::BoxKey> m_missing;
};

}  // namespace terravox::trace
