#pragma once

#include <array>
#include <optional>
#include <span>

#include "raytracer/core/walk/packet_steps.hpp"
#include "raytracer/core/walk/skyline.hpp"
#include "raytracer/core/walk/walk.hpp"

namespace terravox::walk {

/// A ray of the caller's array, stopped by anything but air.
struct LaneRay {
    core::RayState* state;  ///< placed in a voxel
    WalkEnd* end;           ///< kWaits: not known yet
    double t_max = core::kFar;
    Hit* hit = nullptr;  ///< set when it ends in kHit; null: only whether it hits is needed
};

/// Walks rays that have nothing in common, sixteen at a time: each goes through a box of its own,
/// and when one has ended the next takes its lane. Voxel, face and t are those of RayWalk to the
/// last bit. Use one object per thread.
class LaneWalk {
public:
    LaneWalk(BlockReader& reader, const LevelCut& cut, const PacketSteps& steps,
             ThinThings thin = ThinThings::kBlock)
        : m_reader(reader), m_cut(cut), m_steps(steps), m_thin(thin), m_skyline(reader, cut) {}

    /// Sets `end` of the rays whose end is known. The others are left where they met something that
    /// is not handled here (a missing box, a hole, hidden rock, a thin thing that may be passed),
    /// and RayWalk continues from there.
    /// @param rays neighbouring rays next to each other
    void trace(std::span<const LaneRay> rays);
    [[nodiscard]] const WalkCounts& counts() const noexcept { return m_counts; }

private:
    void fill(int lane, std::span<const LaneRay>& rays);
    [[nodiscard]] bool enter(int lane);
    void load(int lane, const voxel::Box& box);
    void update(int lane) noexcept;
    void stop(int lane);
    void let_boxes_go();
    BlockReader& m_reader;
    const LevelCut& m_cut;
    const PacketSteps& m_steps;
    const ThinThings m_thin;
    Skyline m_skyline;
    RayLanes m_lanes;
    std::array<const LaneRay*, RayLanes::kLanes> m_rays{};      ///< ray of each lane; null: idle
    std::array<const voxel::Box*, RayLanes::kLanes> m_boxes{};  ///< box that each lane is in
    WalkCounts m_counts;
};

/// A LaneWalk for this machine; nullopt where it lacks the instructions.
[[nodiscard]] inline std::optional<LaneWalk> lane_walk(BlockReader& reader, const LevelCut& cut,
                                                       ThinThings thin = ThinThings::kBlock) {
    const PacketSteps* steps = packet_steps();
    return steps != nullptr ? std::optional<LaneWalk>(std::in_place, reader, cut, *steps, thin)
                            : std::nullopt;
}

}  // namespace terravox::walk
