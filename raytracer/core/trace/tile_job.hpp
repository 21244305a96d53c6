#pragma once

#include <cstddef>
#include <set>
#include <vector>

#include "common/thread/stop.hpp"
#include "raytracer/core/tiles/tile.hpp"
#include "raytracer/core/trace/ray_wave.hpp"
#include "raytracer/core/trace/sample_accumulator.hpp"
#include "raytracer/core/trace/tile_pixels.hpp"
#include "raytracer/core/trace/tracer_tools.hpp"

namespace terravox::trace {

/// A tile in progress: its rays in waves. When a wave makes no further one, the next sample of each
/// pixel begins. The tile waits only when all remaining rays wait for boxes. The result is a
/// function of the tile alone: waves are shaded whole and in order (docs/adr/0015). Used by one
/// thread at a time.
class TileJob {
public:
    /// About 300 kB, and up to a megabyte with their samples and the rays that they send, which is
    /// what a core's own cache holds on common machines.
    static constexpr std::size_t kWaveRays = 1024;
    /// Begins a tile; memory that the previous one allocated is reused.
    /// @param wave_rays approximate rays in a wave: small waves finish sooner, large ones are
    /// faster per ray as long as they fit the cache
    void start(const tiles::RenderTile& tile, std::size_t wave_rays = kWaveRays);

    /// Continues as far as the boxes in memory allow, or until `stop` requests an end; the next
    /// run() resumes there. Each call advances by at least a ray, a wave or a beam, whatever `stop`
    /// requests, and checks it again within a wave.
    /// @return whether the tile is finished
    [[nodiscard]] bool run(TracerTools& tools, const thread::StopCondition& stop);
    /// Whether it has nothing to do until on_box_loaded().
    [[nodiscard]] bool waits() const noexcept { return m_wave.waits(); }
    /// Boxes that rays have begun to wait for since the last call.
    [[nodiscard]] std::vector<voxel::BoxKey> take_missing() { return m_wave.take_missing(); }
    /// The rays that waited for this box continue with the next run().
    void on_box_loaded(const voxel::BoxKey& key) { m_wave.on_box_loaded(key); }
    /// To be called after run() returned true. One sample for each pixel that
    /// RenderTile::each_pixel visits, in its order.
    [[nodiscard]] tiles::TileResult take_result();

private:
    [[nodiscard]] bool trace(TracerTools& tools, const thread::StopCondition& stop);
    void begin(TracerTools& tools);
    void begin_part(const shade::RayEvaluator& evaluator);
    void begin_round(TracerTools& tools);
    [[nodiscard]] bool end_round(TracerTools& tools);

    std::size_t m_wave_rays = kWaveRays;
    TilePixels m_pixels;
    SampleAccumulator m_accumulator;
    std::vector<shade::SampleSum> m_samples;  ///< of this round, one for each active pixel
    RayWave m_wave;
    bool m_begun = false;
    StageClock m_clock;
    tiles::TraceCounts m_counts;
    std::set<voxel::BoxKey> m_holes;
};

}  // namespace terravox::trace
