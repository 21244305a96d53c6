#include "raytracer/core/walk/walk.hpp"

#include <cstdlib>

#include "raytracer/core/base/material_groups.hpp"

namespace terravox::walk {
namespace {

using voxel::child_bit;
using voxel::TreeCell;

constexpr voxel::VoxelAttr kAir{voxel::Material::kAir, 0, 0, 0, {}, 0};

/// The attributes of a solid voxel that has none of its own because no face of it is visible within
/// its box; where levels meet, one may be. They are those of what lies close above it; deep down it
/// is rock.
voxel::VoxelAttr attr_above(const voxel::Box& box, int x, int y, int z) {
    constexpr int kClose = 3;
    for (int above = y + 1; above < std::min(voxel::kBoxSizeY, y + 1 + kClose); ++above) {
        const auto attr = box.voxel(x, above, z);
        if (!attr)
            break;
        if (*attr != voxel::VoxelAttr{})
            return *attr;
    }
    return {};
}

/// Single steps of a ray through the 4 x 4 x 4 voxels of one brick. A ray that passes a voxel goes
/// on from there: in water each voxel of the way is passed, and the crossings stay those of the
/// brick.
class BrickSteps {
public:
    explicit BrickSteps(const core::RayState& ray) noexcept
        : m_bit(child_bit(ray.voxel[0], ray.voxel[1], ray.voxel[2])) {
        for (int a = 0; a < 3; ++a) {
            m_step[a] = ray.forward[a] ? 1 : -1;
            const double first = static_cast<double>(ray.voxel[a] + (ray.forward[a] ? 1 : 0));
            for (int k = 0; k < 4; ++k)
                m_at[a][k] = ray.crossing(a, first + m_step[a] * k);
            m_room[a] = ray.forward[a] ? 4 - (ray.voxel[a] & 3) : 1 + (ray.voxel[a] & 3);
        }
    }

    /// Steps from the ray's voxel to the first one in `mask`, or out of the brick.
    /// @param ray that of the constructor, where the last call has left it
    /// @return whether one stopped it
    bool to_next(core::RayState& ray, std::uint64_t mask, std::uint64_t& steps) noexcept {
        int i = m_taken[0];
        int j = m_taken[1];
        int k = m_taken[2];
        int bit = m_bit;
        int axis = -1;
        const int dx = m_step[0];
        const int dy = m_step[1] * 16;
        const int dz = m_step[2] * 4;
        double t = ray.t;
        bool stopped = true;
        // Without branches except the end: which axis comes next cannot be predicted, and a
        // misprediction costs more than all three.
        while ((mask >> (bit & 63) & 1) == 0) {
            const double cx = m_at[0][i];
            const double cy = m_at[1][j];
            const double cz = m_at[2][k];
            const int a0 = static_cast<int>(cx <= cy) & static_cast<int>(cx <= cz);
            const int a1 = (a0 ^ 1) & static_cast<int>(cy <= cz);
            const int a2 = (a0 | a1) ^ 1;
            i += a0;
            j += a1;
            k += a2;
            bit += (dx & -a0) + (dy & -a1) + (dz & -a2);
            t = std::min(std::min(cx, cy), cz);
            axis = a1 + 2 * a2;
            if (static_cast<int>(i == m_room[0]) | static_cast<int>(j == m_room[1]) |
                static_cast<int>(k == m_room[2])) {
                stopped = false;
                break;
            }
        }
        const int taken[3] = {i - m_taken[0], j - m_taken[1], k - m_taken[2]};
        for (int a = 0; a < 3; ++a) {
            steps += static_cast<std::uint64_t>(taken[a]);
            ray.voxel[a] += m_step[a] * taken[a];
            m_taken[a] += taken[a];
        }
        m_bit = bit;
        if (axis >= 0) {
            ray.t = t;
            ray.face = core::to_face(axis, !ray.forward[axis]);
        }
        return stopped;
    }

private:
    double m_at[3][5];  ///< the crossings of each axis, from the first voxel on
    int m_step[3];
    int m_room[3];        ///< steps that leave the brick
    int m_taken[3] = {};  ///< steps
    int m_bit;            ///< of the ray's voxel, in masks
};

/// Whether a ray meets a voxel of one brick, which lies ahead of it or around it.
bool meets(const core::RayState& from, const Occluder& brick, std::uint64_t& steps) noexcept {
    if (brick.mask == 0 || brick.level != from.level)
        return false;
    core::RayState ray = from;
    int axis = -1;
    double at = 0;
    for (int a = 0; a < 3; ++a) {
        const std::int32_t low = brick.low[a];
        const std::int32_t high = low + 3;
        const std::int32_t v = ray.voxel[a];
        if (ray.forward[a] ? v > high : v < low)
            return false;
        if (!(ray.forward[a] ? v < low : v > high))
            continue;
        const double c = ray.crossing(a, ray.forward[a] ? low : high + 1.0);
        if (axis < 0 || c >= at) {
            at = c;
            axis = a;
        }
    }
    if (axis >= 0) {
        if (!(at < core::kFar))
            return false;
        for (int a = 0; a < 3; ++a) {
            const std::int32_t low = brick.low[a];
            const std::int32_t high = low + 3;
            if (a == axis) {
                ray.voxel[a] = ray.forward[a] ? low : high;
                continue;
            }
            const std::int32_t p = ray.position_after(
                a, at, axis, ray.forward[a] ? std::max(low - 1, ray.voxel[a]) : low - 1,
                ray.forward[a] ? high + 1 : std::min(ray.voxel[a], high + 1));
            if (p < low || p > high)
                return false;
            ray.voxel[a] = p;
        }
    }
    return BrickSteps(ray).to_next(ray, brick.mask, steps);
}

}  // namespace

// Walks from the ray's voxel, which lies in the box, until something stops the ray (true) or it has
// left the box (false). One function, because this is the hot loop of single rays: the cell, its
// level and the ray's state must stay in registers.
template <bool kAny>
bool RayWalk::walk_box(core::RayState& ray, const blocks::Block& block, StopAt stop, Hit* hit,
                       Occluder* occluder) {
    const voxel::Box& box = *block.box;
    const TreeCell* cells = box.cells().data();
    const std::int32_t bx = ray.voxel[0] >> 6;
    const std::int32_t by = ray.voxel[1] >> 8;
    const std::int32_t bz = ray.voxel[2] >> 6;
    const auto report = [&](const voxel::VoxelAttr& attr) {
        if constexpr (!kAny)
            *hit = {ray.t, {ray.voxel[0], ray.voxel[1], ray.voxel[2]}, ray.face, ray.level, false,
                    attr};
    };
    const auto hidden = [&] {
        if constexpr (!kAny)
            report(ray.face == core::Face::kNone
                       ? voxel::VoxelAttr{}
                       : attr_above(box, ray.voxel[0] & 63, ray.voxel[1] & 255, ray.voxel[2] & 63));
        return true;
    };
    // Returns whether air stops the ray; otherwise the ray leaves the empty cell.
    const auto in_air = [&](int shift) {
        if constexpr (!kAny)
            if (stop.air_stops) {
                report(kAir);
                return true;
            }
        ray.leap(shift);
        return false;
    };
    do {
        ++m_counts.steps;
        const std::int32_t x = ray.voxel[0];
        const std::int32_t y = ray.voxel[1];
        const std::int32_t z = ray.voxel[2];
        const TreeCell* cell = &cells[y >> 6 & 3];
        if (cell->mask == 0) {
            if (in_air(6))
                return true;
            continue;
        }
        int bit = child_bit(x >> 4, y >> 4, z >> 4);
        if ((cell->mask >> bit & 1) == 0) {
            if (in_air(voxel_leap_shift(cell->mask, bit, 4)))
                return true;
            continue;
        }
        if ((cell->detail >> bit & 1) == 0)
            return hidden();
        cell = &cells[cell->compute_index(bit)];
        bit = child_bit(x >> 2, y >> 2, z >> 2);
        if ((cell->mask >> bit & 1) == 0) {
            if (in_air(voxel_leap_shift(cell->mask, bit, 2)))
                return true;
            continue;
        }
        if ((cell->detail >> bit & 1) == 0)
            return hidden();
        cell = &cells[cell->compute_index(bit)];
        if constexpr (!kAny)
            // A brick that is full of what the ray passes is left in one step.
            if (cell->first < block.shared_attrs &&
                box.attrs()[cell->first].material == stop.passed) {
                ray.leap(2);
                continue;
            }
        std::uint64_t mask = !kAny && stop.air_stops ? ~std::uint64_t{0} : cell->mask;
        BrickSteps brick(ray);
        while (brick.to_next(ray, mask, m_counts.steps)) {
            bit = child_bit(ray.voxel[0], ray.voxel[1], ray.voxel[2]);
            if constexpr (kAny) {
                if (m_thin == ThinThings::kBlock) {
                    *occluder = {cell->mask, {x & ~3, y & ~3, z & ~3}, ray.level};
                    return true;
                }
                const std::uint64_t own = std::uint64_t{1} << bit;
                if ((cell->detail & own) == 0 ||
                    !core::is_thin(box.attrs()[cell->compute_index(bit)].material)) {
                    // Of the others in the brick it is not known whether they are thin.
                    *occluder = {own, {x & ~3, y & ~3, z & ~3}, ray.level};
                    return true;
                }
                mask &= ~own;
            } else {
                if (stop.air_stops && (cell->mask >> bit & 1) == 0) {
                    report(kAir);
                    return true;
                }
                if ((cell->detail >> bit & 1) == 0)
                    return hidden();
                const voxel::VoxelAttr& attr = box.attrs()[cell->compute_index(bit)];
                if (attr.material != stop.passed) {
                    report(attr);
                    return true;
                }
                mask &= ~(std::uint64_t{1} << bit);
            }
        }
    } while (ray.voxel[0] >> 6 == bx && ray.voxel[1] >> 8 == by && ray.voxel[2] >> 6 == bz);
    return false;
}

template <bool kAny>
WalkEnd RayWalk::walk(core::RayState& ray, StopAt stop, double t_max, Hit* hit,
                      Occluder* occluder) {
    // Where there is only air, including beyond the world: returns whether that stops the ray.
    const auto in_air = [&] {
        if constexpr (!kAny)
            if (stop.air_stops)
                return *hit = {ray.t,    {ray.voxel[0], ray.voxel[1], ray.voxel[2]},
                               ray.face, ray.level,
                               false,    kAir},
                       true;
        return false;
    };
    while (ray.t <= t_max) {
        int level = ray.level;
        // A very coarse voxel may lie over columns of several finer levels: again, until it lies in
        // one.
        while ((level = m_cut.level_at(ray.voxel[0] << ray.level, ray.voxel[2] << ray.level,
                                       level)) != ray.level)
            ray.change_level(level);
        const voxel::VoxelBounds& bounds = m_cut.bounds(level);
        for (int a = 0; a < 3; ++a) {
            const auto i = static_cast<std::size_t>(a);
            if (ray.forward[a] ? ray.voxel[a] >= bounds.max[i] : ray.voxel[a] < bounds.min[i])
                return in_air() ? WalkEnd::kHit : WalkEnd::kMiss;
        }
        const voxel::BoxKey key{level, ray.voxel[0] >> 6, ray.voxel[1] >> 8, ray.voxel[2] >> 6};
        const blocks::Block* block = m_reader.get(key);
        if (block == nullptr) {
            m_missing = key;
            return WalkEnd::kWaits;
        }
        if (block->hole) {
            m_holes.insert(key);
            if constexpr (kAny)
                occluder->hole = true;
            else
                *hit = {ray.t,    {ray.voxel[0], ray.voxel[1], ray.voxel[2]},
                        ray.face, ray.level,
                        true,     {}};
            return WalkEnd::kHit;
        }
        if (!block->box) {
            ++m_counts.steps;
            if (in_air())
                return WalkEnd::kHit;
            ray.leap(6, 8, 6);
            continue;
        }
        if (walk_box<kAny>(ray, *block, stop, hit, occluder))
            return ray.t <= t_max ? WalkEnd::kHit : WalkEnd::kMiss;
    }
    return WalkEnd::kMiss;
}

// Whether a ray gets from where it is to the brick through no other boxes than its own, which is no
// hole, and the brick's. A hole on its way has to be met, whichever ray has found the brick: the
// holes reported for a picture must not depend on which thread traced which tile before.
bool RayWalk::nothing_between(const core::RayState& ray, const Occluder& brick) {
    const voxel::BoxKey own{ray.level, ray.voxel[0] >> 6, ray.voxel[1] >> 8, ray.voxel[2] >> 6};
    const int apart = std::abs((brick.low[0] >> 6) - own.bx) +
                      std::abs((brick.low[1] >> 8) - own.by) +
                      std::abs((brick.low[2] >> 6) - own.bz);
    if (apart > 1 || m_cut.level_at(ray.voxel[0] << ray.level, ray.voxel[2] << ray.level,
                                    ray.level) != ray.level)
        return false;
    const blocks::Block* block = m_reader.get(own);
    return block != nullptr && !block->hole;
}

WalkEnd RayWalk::any_hit(core::RayState& ray, double t_max, Occluder& occluder) {
    occluder.hole = false;
    // Only without a limit: what stops the ray beyond it does not count.
    if (t_max == core::kFar && meets(ray, occluder, m_counts.steps) &&
        nothing_between(ray, occluder))
        return WalkEnd::kHit;
    return walk<true>(ray, StopAt::kSolid, t_max, nullptr, &occluder);
}

template WalkEnd RayWalk::walk<false>(core::RayState&, StopAt, double, Hit*, Occluder*);
template WalkEnd RayWalk::walk<true>(core::RayState&, StopAt, double, Hit*, Occluder*);

std::optional<Hit> Walker::first_hit(const core::Ray& ray, StopAt stop, double t_max) {
    ++m_rays;
    core::RayState state(ray);
    if (!state.enter(m_walk.cut().entry_bounds()))
        return std::nullopt;
    return finish(state, stop, t_max);
}

std::optional<Hit> Walker::first_hit_from(const core::Ray& ray, core::VoxelCoord start,
                                          int its_level, StopAt stop, double t_max) {
    ++m_rays;
    core::RayState state(ray);
    state.start_in(start, its_level);
    return finish(state, stop, t_max);
}

std::optional<Hit> Walker::finish(core::RayState& ray, StopAt stop, double t_max) {
    Hit hit;
    while (true) {
        const WalkEnd end = m_walk.first_hit(ray, stop, t_max, hit);
        if (end == WalkEnd::kHit)
            return hit;
        if (end == WalkEnd::kMiss)
            return std::nullopt;
        (void)m_walk.reader().blocks().get(m_walk.missing());
    }
}

}  // namespace terravox::walk
