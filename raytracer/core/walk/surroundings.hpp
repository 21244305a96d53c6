#pragma once

#include <cstdint>
#include <vector>

#include "raytracer/core/walk/walk.hpp"

namespace terravox::walk {

/// The neighbour of a voxel across one of its faces.
[[nodiscard]] inline core::VoxelCoord neighbour(core::VoxelCoord v, core::Face face) noexcept {
    const int s = core::to_sign(face);
    switch (core::to_axis(face)) {
        case 0: v.x += s; break;
        case 1: v.y += s; break;
        default: v.z += s; break;
    }
    return v;
}

/// Which voxels around the voxel in front of a face are solid, as far as they have been looked up.
struct Seen {
    std::uint8_t bits = 0;
    std::uint8_t looked = 0;
};

/// Looks up the eight voxels around the one in front of a face. The answers of the last few
/// thousand faces are kept: the samples of a pixel and of its neighbours meet the same ones. Use
/// one object per thread.
class Surroundings {
public:
    Surroundings(BlockReader& reader, const LevelCut& cut)
        : m_reader(reader), m_cut(cut), m_known(kKnown) {}

    /// Sets in `seen.bits` bit `3 * (da + 1) + (db + 1)`, less one beyond the middle (0..7), for
    /// solid voxels, where a and b are the axes after the face's own in cyclic order. Holes count
    /// as solid.
    /// @return false when a box is not in memory: see missing(). The next call continues from
    /// there, so that one box at a time is enough.
    [[nodiscard]] bool around(const Hit& hit, Seen& seen);
    /// Looks up whether a voxel of a level is solid, in the cut's own boxes.
    /// @return false when the box is not in memory
    [[nodiscard]] bool look(core::VoxelCoord voxel, int level, bool& solid);
    [[nodiscard]] const voxel::BoxKey& missing() const noexcept { return m_missing; }
    /// Holes met since the last call: boxes that could not be read.
    [[nodiscard]] std::set<voxel::BoxKey> take_holes() { return std::exchange(m_holes, {}); }

private:
    static constexpr std::size_t kKnown = 8192;
    /// A face whose surroundings hold no hole.
    struct Known {
        core::VoxelCoord voxel;
        std::int8_t level = -1;  ///< -1: no face
        core::Face face = core::Face::kNone;
        std::uint8_t bits = 0;
    };
    [[nodiscard]] Known& find_place(const Hit& hit) noexcept;
    [[nodiscard]] bool look_around(const Hit& hit, Seen& seen);

    BlockReader& m_reader;
    const LevelCut& m_cut;
    std::vector<Known> m_known;
    voxel::BoxKey m_missing;
    bool m_met_hole = false;  ///< since the last call of around()
    std::set<voxel::BoxKey> m_holes;
};

}  // namespace terravox::walk
