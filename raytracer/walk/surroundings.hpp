#pragma once

#include "raytracer/walk/walk.hpp"

namespace terravox::walk {

/// The neighbour of a voxel across one of its faces.
[[nodiscard]] inline core::VoxelCoord neighbour(core::VoxelCoord v, core::Face face) noexcept {
    const int s = core::sign_of(face);
    switch (core::axis_of(face)) {
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

/// Looks up the eight voxels around the one in front of a face. Use one object per thread.
class Surroundings {
public:
    Surroundings(BlockReader& reader, const LevelCut& cut) : m_reader(reader), m_cut(cut) {}

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
    BlockReader& m_reader;
    const LevelCut& m_cut;
    voxel::BoxKey m_missing;
    std::set<voxel::BoxKey> m_holes;
};

}  // namespace terravox::walk
