#pragma once

#include <optional>
#include <utility>

#include "raytracer/core/walk/packet_steps.hpp"
#include "raytracer/core/walk/walk.hpp"

namespace terravox::walk {

/// Walks packets: all rays that are in the first one's box advance through it at the same time.
/// Voxel, face and t are those of RayWalk to the last bit. Use one object per thread.
class PacketWalk {
public:
    /// Bit masks of lanes. Lanes in neither mask are left where they met something that packets do
    /// not handle (a box that is missing or of another level, a hole, hidden rock, a thin thing
    /// that may be passed), and RayWalk continues from there.
    struct Ends {
        std::uint32_t hit = 0;
        std::uint32_t missed = 0;
    };
    PacketWalk(BlockReader& reader, const LevelCut& cut, const PacketSteps& steps,
               ThinThings thin = ThinThings::kBlock)
        : m_reader(reader), m_cut(cut), m_steps(steps), m_thin(thin) {}

    /// @param lanes the lanes of the packet to walk
    /// @param hits one for each lane; set for the lanes that hit
    [[nodiscard]] Ends first_hits(RayPacket& packet, std::uint32_t lanes, Hit* hits) {
        return walk<false>(packet, lanes, hits);
    }
    /// Whether anything solid lies ahead.
    [[nodiscard]] Ends any_hits(RayPacket& packet, std::uint32_t lanes) {
        return walk<true>(packet, lanes, nullptr);
    }
    [[nodiscard]] const WalkCounts& counts() const noexcept { return m_counts; }

private:
    template <bool kAny>
    Ends walk(RayPacket& packet, std::uint32_t lanes, Hit* hits);
    BlockReader& m_reader;
    const LevelCut& m_cut;
    const PacketSteps& m_steps;
    const ThinThings m_thin;
    WalkCounts m_counts;
};

/// A PacketWalk for this machine; nullopt where it lacks the instructions.
[[nodiscard]] inline std::optional<PacketWalk> packet_walk(BlockReader& reader, const LevelCut& cut,
                                                           ThinThings thin = ThinThings::kBlock) {
    const PacketSteps* steps = packet_steps();
    return steps != nullptr ? std::optional<PacketWalk>(std::in_place, reader, cut, *steps, thin)
                            : std::nullopt;
}

}  // namespace terravox::walk
