#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "raytracer/core/walk/packet_steps.hpp"
#include "raytracer/core/walk/walk.hpp"

namespace terravox::walk {

/// From which height on a column of boxes is empty, and squares of 4 x 4 and of 16 x 16 columns, as
/// far as the boxes in memory tell. Of rays that go up, most of the way lies in the empty air above
/// the land: they leave it in one step. Remembers what it has found, for one cut of one world; a
/// box that is not available counts as full. Use one object per thread. Ref: the maximum mipmaps of
/// Tevs, Ihrke, Seidel, "Maximum mipmaps for fast, accurate, and scalable dynamic height field
/// rendering", I3D 2008.
class Skyline {
public:
    Skyline(BlockReader& reader, const LevelCut& cut);

    /// log2 of the edge, in voxels of the ray's level, of an aligned square of columns around the
    /// ray in which nothing is as high as the ray; 0: none is known.
    /// @param ray within the cut's bounds, at the cut's level
    [[nodiscard]] int open_above(const core::RayState& ray);

private:
    static constexpr std::int32_t kUnknown = std::numeric_limits<std::int32_t>::max();
    static constexpr int kSizes = 3;     ///< squares of 1, 4 and 16 columns a side
    static constexpr int kSlotBits = 6;  ///< log2 of the slots along an edge of a table

    struct Square {
        std::int32_t x = 0, z = 0;          ///< counts squares of its size
        std::int32_t free_from = kUnknown;  ///< lowest y, voxels of `level`, with nothing above
        std::int8_t level = -1;             ///< -1: an empty slot
        std::uint8_t lookups = 0;           ///< while unknown; wraps around
    };
    [[nodiscard]] Square& slot(int size, std::int32_t x, std::int32_t z) noexcept;
    [[nodiscard]] std::int32_t lowest_free(int size, const core::RayState& ray);
    [[nodiscard]] std::int32_t look_down(const Square& column);
    [[nodiscard]] std::int32_t highest_of_parts(int size, const Square& square) noexcept;

    BlockReader& m_reader;
    const LevelCut& m_cut;
    std::array<std::vector<Square>, kSizes> m_squares;
};

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
