#pragma once

#include <array>
#include <optional>
#include <span>

#include "raytracer/walk/packet_steps.hpp"
#include "raytracer/walk/walk.hpp"

namespace terravox::walk {

/// A ray in somebody's array, that anything but air stops.
struct LaneRay {
    core::RayState* state;  ///< placed in a voxel
    WalkEnd* end;           ///< kWaits: not known yet
    double t_max = core::kFar;
    Hit* hit = nullptr;  ///< set where it ends in kHit; null: it only asks
};

/// Walks rays that have nothing in common, sixteen at a time: each goes through a box of its own,
/// and where one has ended the next takes its place. Voxel, face and t are those of RayWalk to the
/// last bit. One for each thread.
class LaneWalk {
public:
    LaneWalk(BlockReader& reader, const LevelCut& cut, const PacketSteps& steps)
        : m_reader(reader), m_cut(cut), m_steps(steps) {}

    /// Sets `end` of those that are known; the others are where they stopped for something that is
    /// not done here (a box that is missing, a hole, hidden rock): RayWalk goes on from there.
    /// @param rays neighbours beside each other
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
    RayLanes m_lanes;
    std::array<const LaneRay*, RayLanes::kLanes> m_rays{};      ///< of the lanes; null: idle
    std::array<const voxel::Box*, RayLanes::kLanes> m_boxes{};  ///< that they are in
    WalkCounts m_counts;
};

/// For this machine; nothing where it lacks the instructions.
[[nodiscard]] inline std::optional<LaneWalk> lane_walk(BlockReader& reader, const LevelCut& cut) {
    const PacketSteps* steps = packet_steps();
    return steps != nullptr ? std::optional<LaneWalk>(std::in_place, reader, cut, *steps)
                            : std::nullopt;
}

}  // namespace terravox::walk
