#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <utility>

#include "common/voxel/box.hpp"
#include "raytracer/core/base/ray_state.hpp"
#include "raytracer/core/walk/block_reader.hpp"
#include "raytracer/core/walk/level_cut.hpp"

namespace terravox::walk {

struct Hit {
    /// To the face, in multiples of the ray's direction; 0 when the ray starts inside.
    double t = 0;
    core::VoxelCoord voxel;  ///< of `level`
    /// The face through which the ray entered the voxel; kNone when it starts inside.
    core::Face face = core::Face::kNone;
    std::int8_t level = 0;
    bool hole = false;  ///< not a voxel but a box that is not available
    voxel::VoxelAttr attr;
};

/// What a walk stops at: everything but one material and, usually, air.
struct StopAt {
    voxel::Material passed = voxel::Material::kAir;
    bool air_stops = false;
    friend bool operator==(const StopAt&, const StopAt&) = default;

    static const StopAt kSolid;     ///< anything but air
    static const StopAt kNotWater;  ///< anything but air and water: how light reaches a lake's bed
    /// Where a medium ends, even if at air. Air is reported as a hit with the material air.
    [[nodiscard]] static constexpr StopAt find_end(voxel::Material medium) noexcept {
        return {medium, true};
    }
};
inline constexpr StopAt StopAt::kSolid{};
inline constexpr StopAt StopAt::kNotWater{voxel::Material::kWater, false};

enum class WalkEnd : std::uint8_t {
    kHit,
    kMiss,
    kWaits,  ///< for a box that is not in memory: the walk may be resumed from where the ray is
};

/// What voxels of thin things (core::is_thin) mean to rays of which only matters whether anything
/// blocks them. All other rays meet them.
enum class ThinThings : std::uint8_t { kBlock, kPass };

struct WalkCounts {
    std::uint64_t steps = 0;  ///< cells and voxels visited
};

/// Length of a leap out of an empty child of a cell, as log2 of voxels: the child's own size, or
/// twice that where the seven others of its aligned 2 x 2 x 2 are empty as well.
[[nodiscard]] inline int voxel_leap_shift(std::uint64_t mask, int bit, int child_shift) noexcept {
    constexpr std::uint64_t kEight = 0x330033;
    constexpr int kCorner = ~(1 | 4 | 16);
    return (mask >> (bit & kCorner) & kEight) != 0 ? child_shift : child_shift + 1;
}

/// A brick that stopped a ray: the next ray of the same direction often meets it, too.
struct Occluder {
    std::uint64_t mask = 0;  ///< of the 4 x 4 x 4 voxels; 0: none
    std::int32_t low[3] = {};
    std::int8_t level = 0;
    /// The last ray was stopped not by a brick but by a box that is not available.
    bool hole = false;
};

/// Walks rays through the boxes of a cut, from box to box, and in each through cells of 64, 16 and
/// 4 voxels, always leaping over the largest empty one (8 children together where all are empty).
/// It never blocks: it returns kWaits when a box is missing. For coordinates see RayState. Use one
/// object per thread. Ref: Amanatides & Woo, "A Fast Voxel Traversal Algorithm", Eurographics 1987;
/// Museth, "Hierarchical Digital Differential Analyzer", SIGGRAPH Talks 2014.
class RayWalk {
public:
    RayWalk(BlockReader& reader, const LevelCut& cut, ThinThings thin = ThinThings::kBlock)
        : m_reader(reader), m_cut(cut), m_thin(thin) {}

    /// Walks from the ray's position to the first voxel that stops it with t <= t_max.
    [[nodiscard]] WalkEnd first_hit(core::RayState& ray, StopAt stop, double t_max, Hit& hit) {
        return walk<false>(ray, stop, t_max, &hit, nullptr);
    }
    /// Tests whether anything solid lies ahead, thin things as given to the constructor; kHit also
    /// for holes.
    /// @param occluder in: tested first; out: what stopped the ray
    [[nodiscard]] WalkEnd any_hit(core::RayState& ray, double t_max, Occluder& occluder);

    /// The box that a ray with kWaits needs.
    [[nodiscard]] const voxel::BoxKey& missing() const noexcept { return m_missing; }
    [[nodiscard]] BlockReader& reader() noexcept { return m_reader; }
    [[nodiscard]] const LevelCut& cut() const noexcept { return m_cut; }
    [[nodiscard]] const WalkCounts& counts() const noexcept { return m_counts; }
    /// Holes met since the last call: boxes that could not be read.
    [[nodiscard]] std::set<voxel::BoxKey> take_holes() { return std::exchange(m_holes, {}); }

private:
    [[nodiscard]] bool nothing_between(const core::RayState& ray, const Occluder& brick);
    template <bool kAny>
    WalkEnd walk(core::RayState& ray, StopAt stop, double t_max, Hit* hit, Occluder* occluder);
    template <bool kAny>
    bool walk_box(core::RayState& ray, const blocks::Block& block, StopAt stop, Hit* hit,
                  Occluder* occluder);

    BlockReader& m_reader;
    const LevelCut& m_cut;
    const ThinThings m_thin;
    voxel::BoxKey m_missing;
    std::set<voxel::BoxKey> m_holes;
    WalkCounts m_counts;
};

/// RayWalk for one ray at a time, blocking while boxes are loaded: for tests, measurements, and
/// looking up a single point. Not thread-safe.
class Walker {
public:
    /// @param cut must outlive the walker
    Walker(BlockReader& reader, const LevelCut& cut) : m_walk(reader, cut) {}

    /// The first voxel that stops the ray with t in [0, t_max].
    /// @param ray level-0 voxels
    [[nodiscard]] std::optional<Hit> first_hit(const core::Ray& ray, StopAt stop = StopAt::kSolid,
                                               double t_max = core::kFar);

    /// The same for a ray that starts on a face: `start`, of `its_level`, is the voxel it starts
    /// in, whatever rounding makes of its origin.
    [[nodiscard]] std::optional<Hit> first_hit_from(const core::Ray& ray, core::VoxelCoord start,
                                                    int its_level = 0, StopAt stop = StopAt::kSolid,
                                                    double t_max = core::kFar);

    [[nodiscard]] std::uint64_t rays() const noexcept { return m_rays; }
    [[nodiscard]] std::uint64_t steps() const noexcept { return m_walk.counts().steps; }

private:
    [[nodiscard]] std::optional<Hit> finish(core::RayState& ray, StopAt stop, double t_max);
    RayWalk m_walk;
    std::uint64_t m_rays = 0;
};

}  // namespace terravox::walk
