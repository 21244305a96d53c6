#include "raytracer/core/walk/packet_walk.hpp"

#include <bit>

#include "raytracer/core/base/material_groups.hpp"

namespace terravox::walk {
namespace {

using voxel::child_bit;
using voxel::TreeCell;

/// Whether a lane, in a solid voxel of a box, is in one of a thin thing.
bool is_in_thin(const RayPacket& p, int lane, const voxel::Box& box) noexcept {
    const TreeCell& brick = box.cells()[p.brick[lane]];
    const int bit = child_bit(static_cast<std::int32_t>(p.voxel[0][lane]),
                              static_cast<std::int32_t>(p.voxel[1][lane]),
                              static_cast<std::int32_t>(p.voxel[2][lane]));
    return p.brick[lane] != 0 && (brick.detail >> bit & 1) != 0 &&
           core::is_thin(box.attrs()[brick.compute_index(bit)].material);
}

}  // namespace

// One function, because its masks and pointers must stay in registers: calls in this loop cost more
// than they would clarify.
template <bool kAny>
PacketWalk::Ends PacketWalk::walk(RayPacket& p, std::uint32_t lanes, Hit* hits) {
    Ends ends;
    voxel::BoxKey own;                     // the box that the last cells were in,
    const blocks::Block* block = nullptr;  // valid until the next call of the reader
    std::uint32_t active = lanes;
    while (active != 0) {
        const int lane = std::countr_zero(active);
        const std::int32_t v[3] = {static_cast<std::int32_t>(p.voxel[0][lane]),
                                   static_cast<std::int32_t>(p.voxel[1][lane]),
                                   static_cast<std::int32_t>(p.voxel[2][lane])};
        ++m_counts.steps;
        if (p.is_free(lane)) {
            ends.missed |= 1u << lane;
            active &= active - 1;
            continue;
        }
        const voxel::BoxKey key{p.level, v[0] >> 6, v[1] >> 8, v[2] >> 6};
        if (block == nullptr || key != own) {
            const int level = m_cut.level_at(v[0] << p.level, v[2] << p.level, p.level);
            if (level > p.level) {
                // Rays that are still among finer boxes continue alone, from where they are.
                for (std::uint32_t left = active; left != 0; left &= left - 1) {
                    const int i = std::countr_zero(left);
                    const std::int32_t x = static_cast<std::int32_t>(p.voxel[0][i]) << p.level;
                    const std::int32_t z = static_cast<std::int32_t>(p.voxel[2][i]) << p.level;
                    if (m_cut.level_at(x, z, p.level) < level)
                        active &= ~(1u << i);
                }
                p.coarsen(level, active);
                block = nullptr;
                continue;
            }
            const voxel::VoxelBounds& bounds = m_cut.bounds(p.level);
            bool beyond = false;
            for (std::size_t a = 0; a < 3; ++a)
                beyond = beyond || (p.forward[a] ? v[a] >= bounds.max[a] : v[a] < bounds.min[a]);
            block = beyond || level < p.level ? nullptr : m_reader.get(key);
            if (block == nullptr || block->hole) {
                if (beyond && level == p.level)
                    ends.missed |= 1u << lane;
                block = nullptr;
                active &= active - 1;
                continue;
            }
            own = key;
        }
        const double x = key.bx * 64.0;
        const double y = key.by * 256.0;
        const double z = key.bz * 64.0;
        const PacketCell cell{{x, y, z}, {x + 63, y + 255, z + 63}};
        if (!block->box) {
            m_steps.leap(p, cell, m_steps.inside(p, cell, active));
            continue;
        }
        const TreeCell* cells = block->box->cells().data();
        const std::uint32_t stopped = m_steps.box(p, cells, cell, active, m_counts.steps);
        active &= ~stopped;
        if constexpr (kAny) {
            if (m_thin == ThinThings::kBlock) {
                ends.hit |= stopped;
                continue;
            }
            for (std::uint32_t left = stopped; left != 0; left &= left - 1)
                if (!is_in_thin(p, std::countr_zero(left), *block->box))
                    ends.hit |= left & -left;
        } else {
            for (std::uint32_t left = stopped; left != 0; left &= left - 1) {
                const int i = std::countr_zero(left);
                const core::VoxelCoord at{static_cast<std::int32_t>(p.voxel[0][i]),
                                          static_cast<std::int32_t>(p.voxel[1][i]),
                                          static_cast<std::int32_t>(p.voxel[2][i])};
                const int bit = child_bit(at.x, at.y, at.z);
                const TreeCell& brick = cells[p.brick[i]];
                if (p.brick[i] == 0 || (brick.detail >> bit & 1) == 0)
                    continue;
                const voxel::VoxelAttr& attr = block->box->attrs()[brick.compute_index(bit)];
                if (attr.material == voxel::Material::kAir)
                    // Only possible with an invalid box of an untrusted server: nothing stops at
                    // it.
                    continue;
                const int axis = static_cast<int>(p.axis[i]);
                hits[i] = {p.t[i],
                           at,
                           axis < 0 ? core::Face::kNone : core::to_face(axis, !p.forward[axis]),
                           static_cast<std::int8_t>(p.level),
                           false,
                           attr};
                ends.hit |= 1u << i;
            }
        }
    }
    return ends;
}

template PacketWalk::Ends PacketWalk::walk<false>(RayPacket&, std::uint32_t, Hit*);
template PacketWalk::Ends PacketWalk::walk<true>(RayPacket&, std::uint32_t, Hit*);

}  // namespace terravox::walk
