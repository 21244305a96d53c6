#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "raytracer/analyse/evaluator.hpp"
#include "raytracer/walk/lane_walk.hpp"
#include "raytracer/walk/packet_walk.hpp"
#include "raytracer/walk/shaft.hpp"

namespace terravox::trace {

/// What one thread needs to trace tiles of a view.
struct TracerTools {
    /// @param of, blocks must outlive this
    /// @param pinned_bytes of blocks that the thread may keep from being evicted
    TracerTools(const shade::View& of, blocks::BlockManager& blocks, std::size_t pinned_bytes)
        : TracerTools(of, blocks, pinned_bytes / (keeps_light(of) ? 2 : 1), of.cut) {
        if (!keeps_light(of))
            return;
        gather_cut.emplace(of.cut);
        gather.reset(new TracerTools(of, blocks, pinned_bytes / 2, *gather_cut));
        gather->gathers = true;
    }

    const shade::View& view;
    walk::BlockReader reader;
    walk::RayWalk walk;
    std::optional<walk::PacketWalk> packets;  ///< where the machine has the instructions
    std::optional<walk::LaneWalk> lanes;      ///< where the machine has the instructions
    walk::BeamMarch beams;
    walk::ShaftMarch shafts;
    walk::Surroundings surroundings;
    std::unique_ptr<const shade::RayEvaluator> shading;
    walk::Occluder occluder;
    /// The cut that rays of `gather` are walked by, which each wave of them sets anew.
    std::optional<walk::LevelCut> gather_cut;
    bool gathers = false;                 ///< for gather rays
    std::unique_ptr<TracerTools> gather;  ///< for rays that gather light to keep; null: none do

    [[nodiscard]] std::uint64_t steps() const noexcept {
        return walk.counts().steps + (packets ? packets->counts().steps : 0) +
               (lanes ? lanes->counts().steps : 0) + (gather ? gather->steps() : 0);
    }
    [[nodiscard]] std::uint64_t slabs() const noexcept {
        return beams.slabs() + shafts.slabs() + (gather ? gather->slabs() : 0);
    }

private:
    TracerTools(const shade::View& of, blocks::BlockManager& blocks, std::size_t pinned_bytes,
                const walk::LevelCut& cut)
        : view(of),
          reader(blocks, pinned_bytes),
          walk(reader, cut),
          packets(walk::packet_walk(reader, cut)),
          lanes(walk::lane_walk(reader, cut)),
          beams(reader, cut),
          shafts(reader, cut),
          surroundings(reader, cut),
          shading(analyse::make_evaluator(of, cut)) {}
    [[nodiscard]] static bool keeps_light(const shade::View& of) noexcept {
        return of.kept_light != nullptr && of.scene.analysis.kind == core::AnalysisKind::kNone;
    }
};

}  // namespace terravox::trace
