#pragma once

#include <cstdint>
#include <set>
#include <unordered_map>
#include <utility>
#include <vector>

#include "raytracer/core/walk/traced_ray.hpp"
#include "raytracer/core/walk/walk.hpp"

namespace terravox::walk {

/// Chooses one of the lamps near a point, the brighter and nearer ones more often: which lamps
/// there are is known from the boxes around. Use one object per thread.
class LampQuery {
public:
    LampQuery(BlockReader& reader, const LevelCut& cut) : m_reader(reader), m_cut(cut) {}

    /// Chooses among the lamps whose middle is within measure_reach() of a point of the face that
    /// was hit, and that are not wholly behind it. The choice is a function of the world, the cut
    /// and the arguments.
    /// @param point on the face, level-0 voxels
    /// @param number [0, 1), at random
    /// @return false when a box is not in memory: see missing(). The lamps of boxes that have been
    /// looked at are remembered, so that one box at a time is enough, and a box that was missing
    /// may not be read any more once it has come.
    [[nodiscard]] bool choose(const Hit& hit, core::Vec3 point, double number, LampChoice& out);
    [[nodiscard]] const voxel::BoxKey& missing() const noexcept { return m_missing; }
    /// Holes met since the last call: boxes that could not be read.
    [[nodiscard]] std::set<voxel::BoxKey> take_holes() { return std::exchange(m_holes, {}); }

    /// Level-0 voxels.
    [[nodiscard]] static double measure_reach(int level) noexcept;

private:
    /// Lamps of one level and one cube of 16 voxels a side, next to each other in `lamps`.
    struct Group {
        std::size_t first = 0;
        std::size_t end = 0;
        core::Vec3 low;  ///< of their middles
        core::Vec3 high;
    };
    /// What one box holds, or several.
    struct Lamps {
        std::vector<LampVoxel> lamps;
        std::vector<voxel::BoxKey> holes;
        std::vector<Group> groups;
        bool are_too_many = false;  ///< to be sampled
    };
    struct Range;
    struct Asked;

    static void group(Lamps& of);
    [[nodiscard]] static double importance(const Asked& at, const Group& group, double edge);
    [[nodiscard]] const Lamps* around(const voxel::BoxKey& key);
    [[nodiscard]] bool collect(int level, std::int32_t bx, std::int32_t bz, const Range& range,
                               Lamps& out);
    [[nodiscard]] const Lamps* of_box(const voxel::BoxKey& key);
    void forget_if_many();

    BlockReader& m_reader;
    const LevelCut& m_cut;
    voxel::BoxKey m_missing;
    std::set<voxel::BoxKey> m_holes;
    std::unordered_map<voxel::BoxKey, Lamps, voxel::BoxKeyHash> m_of_box;
    std::unordered_map<voxel::BoxKey, Lamps, voxel::BoxKeyHash> m_around;
    std::size_t m_kept = 0;  ///< lamps and lists in both
};

}  // namespace terravox::walk
