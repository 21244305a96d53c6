#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "raytracer/shade/shading.hpp"
#include "raytracer/tiles/tile.hpp"
#include "raytracer/trace/pixel_blocks.hpp"
#include "raytracer/trace/pixel_sum.hpp"
#include "raytracer/trace/shadow_groups.hpp"
#include "raytracer/walk/lane_walk.hpp"

namespace terravox::trace {

/// What one thread needs to trace tiles of a view.
struct TracerTools {
    TracerTools(const shade::View& of, blocks::BlockManager& blocks, std::size_t pinned_bytes)
        : view(of),
          reader(blocks, pinned_bytes),
          walk(reader, of.cut),
          packets(walk::packet_walk(reader, of.cut)),
          lanes(walk::lane_walk(reader, of.cut)),
          beams(reader, of.cut),
          shafts(reader, of.cut),
          surroundings(reader, of.cut),
          shading(shade::make_shading(of)) {}
    const shade::View& view;
    walk::BlockReader reader;
    walk::RayWalk walk;
    std::optional<walk::PacketWalk> packets;  ///< where the machine has the instructions, as
    std::optional<walk::LaneWalk> lanes;      ///< this
    walk::BeamMarch beams;
    walk::ShaftMarch shafts;
    walk::Surroundings surroundings;
    std::unique_ptr<const shade::Shading> shading;
    walk::Occluder occluder;
    [[nodiscard]] std::uint64_t steps() const noexcept {
        return walk.counts().steps + (packets ? packets->counts().steps : 0) +
               (lanes ? lanes->counts().steps : 0);
    }
    [[nodiscard]] std::uint64_t slabs() const noexcept { return beams.slabs() + shafts.slabs(); }
};

/// When who works through much is to leave off: when one of two flags is set, or a moment has come.
class StopCondition {
public:
    using Clock = std::chrono::steady_clock;
    /// @param stop, also outlive this
    StopCondition(const std::atomic<bool>& stop, const std::atomic<bool>& also,
                  Clock::time_point at = Clock::time_point::max()) noexcept
        : m_stop(stop), m_also(also), m_at(at) {}
    StopCondition(const std::atomic<bool>& stop,
                  Clock::time_point at = Clock::time_point::max()) noexcept
        : StopCondition(stop, stop, at) {}
    [[nodiscard]] bool asked() const noexcept {
        return m_stop.load(std::memory_order_relaxed) || m_also.load(std::memory_order_relaxed) ||
               (m_at != Clock::time_point::max() && Clock::now() >= m_at);
    }

private:
    const std::atomic<bool>&m_stop, &m_also;
    Clock::time_point m_at;
};

/// A tile on its way: its rays in waves. A wave is walked, then shaded in order, which makes the
/// next wave; when none comes, the next sample of each pixel begins. A ray whose box is missing is
/// laid aside with that box while the others go on; only when all that are left wait does the tile
/// wait. The result is a function of the tile alone: waves are shaded whole and in order.
/// docs/adr/0015. Used by one thread at a time.
class TileJob {
public:
    /// Begins a tile; what the one before has allocated is used again.
    /// @param wave_rays in a wave, about: fewer are sooner done, more go faster
    void start(const tiles::RenderTile& tile, std::size_t wave_rays = kWaveRays);
    static constexpr std::size_t kWaveRays = 4096;  ///< about a megabyte

    /// Goes on as far as the boxes in memory allow, or until it is asked to leave off; the next
    /// run() then goes on from there. Each call gets ahead by a ray, a wave or a beam at least,
    /// whatever `halt` says, and hears of it again within a wave.
    /// @return whether the tile is finished
    [[nodiscard]] bool run(TracerTools& tools, const StopCondition& stop_condition);
    /// Whether it has nothing to do before box_came().
    [[nodiscard]] bool waits() const noexcept { return m_pending.empty() && !m_parked.empty(); }
    /// Boxes that rays have begun to wait for since the last call.
    [[nodiscard]] std::vector<voxel::BoxKey> take_missing() { return std::exchange(m_missing, {}); }
    /// The rays that waited for this box go on with the next run().
    void box_came(const voxel::BoxKey& key);
    /// After run() said so. One sample for each pixel that RenderTile::each_pixel visits, in its
    /// order.
    [[nodiscard]] tiles::TileResult take_result();

private:
    /// A pixel of the part that is being traced, summed up over its samples.
    struct Pixel {
        int x = 0, y = 0;
        std::uint32_t place = 0;  ///< in the result
        const PixelBlock* block = nullptr;
    };
    void begin(TracerTools& tools);
    /// The time since the last call, or since run(), went into this stage.
    void lap(tiles::TraceStage stage);
    [[nodiscard]] std::size_t lattice_index(int column, int row) const noexcept;
    void begin_part(const shade::View& view);
    void make_primary(TracerTools& tools);
    void make_single(TracerTools& tools, std::uint32_t place);
    [[nodiscard]] std::pair<double, double> picture_point(const shade::View& view,
                                                          std::uint32_t place) const noexcept;
    [[nodiscard]] bool go_on(TracerTools& tools, const StopCondition& stop_condition);
    [[nodiscard]] bool walk_pending(TracerTools& tools, const StopCondition& stop_condition);
    [[nodiscard]] bool walk_ray(TracerTools& tools, walk::TracedRay& ray, voxel::BoxKey& missing);
    void trace_primary_packet(TracerTools& tools, const PixelBlock& block, std::uint32_t first,
                              std::uint32_t count);
    void trace_shadow_groups(TracerTools& tools);
    void trace_scattered(TracerTools& tools);
    void shade_wave(TracerTools& tools);
    [[nodiscard]] bool end_round(const shade::View& view);
    void end_part(const shade::View& view);

    tiles::RenderTile m_tile;
    std::size_t m_wave_rays = kWaveRays;
    PixelLattice m_lattice;
    std::vector<std::int32_t>
        m_place;  ///< of a lattice point in the result; -1: an earlier pass has it
    std::vector<PixelBlock> m_blocks;
    std::vector<tiles::PixelSample> m_samples;
    std::size_t m_part_begin = 0, m_part_end = 0;  ///< blocks that are being traced: a large tile
                                                   ///< goes part by part, for memory's sake
    std::vector<Pixel> m_pixels;                   ///< of the part
    std::vector<PixelSum> m_pixel_sums;
    std::vector<LayerSum> m_layer_sums;  ///< empty where nobody asks for layers
    std::vector<tiles::LayerSample> m_layers;
    std::vector<std::uint32_t> m_active;   ///< pixels of the part that need more samples
    std::vector<shade::SampleSum> m_sums;  ///< of this round, one for each of those
    std::vector<walk::TracedRay> m_wave, m_next;
    std::vector<ShadowRay> m_shadows;  ///< of the wave
    std::vector<walk::LaneRay> m_scattered;
    std::vector<std::uint32_t> m_pending;
    std::unordered_map<voxel::BoxKey, std::vector<std::uint32_t>, voxel::BoxKeyHash> m_parked;
    std::vector<voxel::BoxKey> m_missing;
    int m_round = -1;  ///< which sample of each pixel of the part; -1: not begun
    tiles::TraceCounts m_counts;
    std::chrono::steady_clock::time_point m_lap;  ///< when the stage began that is under way
    std::set<voxel::BoxKey> m_holes;
};

}  // namespace terravox::trace
