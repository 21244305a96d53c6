#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>

#include "raytracer/core/shade/shading.hpp"
#include "raytracer/core/tiles/tile.hpp"
#include "raytracer/core/walk/lamp_query.hpp"
#include "raytracer/core/walk/lane_walk.hpp"
#include "raytracer/core/walk/packet_walk.hpp"
#include "raytracer/core/walk/shaft.hpp"

namespace terravox::trace {

/// Attributes a thread's time to stages.
class StageClock {
public:
    void restart() noexcept { m_since = Clock::now(); }
    /// Adds the time since the last call, or since restart(), to this stage.
    void lap(tiles::TraceStage stage, tiles::TraceCounts& counts) noexcept {
        const Clock::time_point now = Clock::now();
        counts.seconds[static_cast<std::size_t>(stage)] +=
            std::chrono::duration<double>(now - m_since).count();
        m_since = now;
    }

private:
    using Clock = std::chrono::steady_clock;
    Clock::time_point m_since;
};

/// What one thread needs to trace tiles of a view.
struct TracerTools {
    /// @param of, blocks must outlive this
    /// @param pinned_bytes of blocks that the thread may keep from being evicted
    TracerTools(const shade::View& of, blocks::BlockManager& blocks, std::size_t pinned_bytes)
        : view(of),
          reader(blocks, pinned_bytes),
          walk(reader, of.cut, of.thin_things()),
          packets(walk::packet_walk(reader, of.cut, of.thin_things())),
          lanes(walk::lane_walk(reader, of.cut, of.thin_things())),
          beams(reader, of.cut),
          shafts(reader, of.cut),
          surroundings(reader, of.cut),
          lamps(reader, of.cut),
          shading(shade::make_evaluator(of)) {}

    const shade::View& view;
    walk::BlockReader reader;
    walk::RayWalk walk;
    std::optional<walk::PacketWalk> packets;  ///< where the machine has the instructions
    std::optional<walk::LaneWalk> lanes;      ///< where the machine has the instructions
    walk::BeamMarch beams;
    walk::ShaftMarch shafts;
    walk::Surroundings surroundings;
    walk::LampQuery lamps;
    std::unique_ptr<const shade::RayEvaluator> shading;
    walk::Occluder occluder;

    [[nodiscard]] std::uint64_t steps() const noexcept {
        return walk.counts().steps + (packets ? packets->counts().steps : 0) +
               (lanes ? lanes->counts().steps : 0);
    }
    [[nodiscard]] std::uint64_t slabs() const noexcept { return beams.slabs() + shafts.slabs(); }
};

}  // namespace terravox::trace
