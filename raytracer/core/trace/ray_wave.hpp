#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "common/thread/stop.hpp"
#include "common/voxel/box.hpp"
#include "raytracer/core/tiles/tile.hpp"
#include "raytracer/core/trace/fan_tracer.hpp"
#include "raytracer/core/trace/tile_pixels.hpp"
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

/// Makes the rays of one sample of each active pixel: in packets for a block whose rays start
/// together, where the machine has the instructions, otherwise one by one. A ray that hits nothing,
/// or whose end a packet has found, does not become pending.
class PrimaryRays {
public:
    /// @param samples of the active pixels; sets their random numbers
    /// @param active indices into `pixels`, ascending
    /// @param counts of the tile
    PrimaryRays(TracerTools& tools, std::span<const TilePixel> pixels,
                std::span<const std::uint32_t> active, std::span<shade::SampleSum> samples,
                RayWave& wave, tiles::TraceCounts& counts) noexcept
        : m_tools(tools),
          m_pixels(pixels),
          m_active(active),
          m_samples(samples),
          m_wave(wave),
          m_counts(counts) {}

    /// @param sample index of the sample, the same for all pixels
    void make(std::uint32_t sample);

private:
    void make_single(std::uint32_t place);
    void make_packet(const PixelBlock& block, std::uint32_t first, std::uint32_t count);
    [[nodiscard]] std::pair<double, double> picture_point(std::uint32_t place) const noexcept;

    TracerTools& m_tools;
    std::span<const TilePixel> m_pixels;
    std::span<const std::uint32_t> m_active;
    std::span<shade::SampleSum> m_samples;
    RayWave& m_wave;
    std::span<walk::TracedRay> m_rays;  ///< of the wave, one for each active pixel
    tiles::TraceCounts& m_counts;
};

}  // namespace terravox::trace
