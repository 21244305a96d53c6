#include "tests/bench/paper/cube_trees.hpp"

#include <algorithm>
#include <bit>
#include <tuple>

#include "common/voxel/box.hpp"
#include "raytracer/walk/walk.hpp"

namespace terravox::bench {
namespace {

constexpr int kChildBits = 6;  // of a path, for each level
constexpr std::uint32_t kChildMask = (1U << kChildBits) - 1;

/// Calls visit(bit) for each bit that is set.
template <class Visit>
void each_bit(std::uint64_t mask, const Visit& visit) {
    for (; mask != 0; mask &= mask - 1)
        visit(std::countr_zero(mask));
}

/// Where a child of a cell lies in it, in children.
core::VoxelCoord place_of(int bit) noexcept {
    return {bit & 3, bit >> 4, bit >> 2 & 3};
}

/// The bricks of a cell of 4 x 4 x 4 bricks.
void add_bricks(const voxel::Box& box, const voxel::TreeCell& cell, core::VoxelCoord first,
                std::vector<Brick>& out) {
    each_bit(cell.mask, [&](int bit) {
        const core::VoxelCoord in = place_of(bit);
        const bool detailed = (cell.detail >> bit & 1) != 0;
        out.push_back({{first.x + in.x, first.y + in.y, first.z + in.z},
                       detailed ? box.cells()[cell.index_of(bit)].mask : ~std::uint64_t{0}});
    });
}

void add_bricks(const voxel::Box& box, std::vector<Brick>& out) {
    constexpr voxel::TreeCell kSolid{~std::uint64_t{0}, 0, 0, 0};
    constexpr int kCellsUp = 4;  // cells of 16 voxels in a root of 64
    const voxel::BoxKey& key = box.key();
    for (int root = 0; root < voxel::Box::kRootCount; ++root) {
        const voxel::TreeCell& cell = box.cells()[static_cast<std::size_t>(root)];
        each_bit(cell.mask, [&](int bit) {
            const core::VoxelCoord in = place_of(bit);
            const bool detailed = (cell.detail >> bit & 1) != 0;
            const core::VoxelCoord first{
                4 * (kCellsUp * key.bx + in.x),
                4 * (kCellsUp * (voxel::Box::kRootCount * key.by + root) + in.y),
                4 * (kCellsUp * key.bz + in.z)};
            add_bricks(box, detailed ? box.cells()[cell.index_of(bit)] : kSolid, first, out);
        });
    }
}

}  // namespace

std::vector<Brick> bricks_of(voxel::World& world) {
    std::vector<Brick> out;
    const voxel::BoxRange range = voxel::boxes_over(world.info().bounds, 0);
    for (std::int32_t bx = range.min.bx; bx < range.max.bx; ++bx)
        for (std::int32_t bz = range.min.bz; bz < range.max.bz; ++bz)
            for (std::int32_t by = range.min.by; by < range.max.by; ++by)
                if (const auto box = world.box({0, bx, by, bz}))
                    add_bricks(*box, out);
    return out;
}

template <int kLevels>
std::uint32_t CubeTrees<kLevels>::Node::child(int bit) const noexcept {
    return first +
           static_cast<std::uint32_t>(std::popcount(mask & ((std::uint64_t{1} << bit) - 1)));
}

template <int kLevels>
auto CubeTrees<kLevels>::placed(const Brick& brick) noexcept -> PlacedBrick {
    constexpr int kBricksBits = kEdgeBits - 2;  // bricks along an edge
    PlacedBrick out;
    out.cube = {0, brick.at.x >> kBricksBits, brick.at.y >> kBricksBits, brick.at.z >> kBricksBits};
    for (int shift = kBricksBits - 2; shift >= 0; shift -= 2)
        out.path = out.path << kChildBits |
                   static_cast<std::uint32_t>(voxel::child_bit(
                       brick.at.x >> shift, brick.at.y >> shift, brick.at.z >> shift));
    out.mask = brick.mask;
    return out;
}

template <int kLevels>
CubeTrees<kLevels>::CubeTrees(const std::vector<Brick>& bricks, const voxel::VoxelBounds& bounds)
    : m_bounds(bounds) {
    std::vector<PlacedBrick> sorted;
    sorted.reserve(bricks.size());
    for (const Brick& brick : bricks)
        sorted.push_back(placed(brick));
    std::sort(sorted.begin(), sorted.end(), [](const PlacedBrick& a, const PlacedBrick& b) {
        return std::tie(a.cube, a.path) < std::tie(b.cube, b.path);
    });
    const PlacedBrick* const end = sorted.data() + sorted.size();
    for (const PlacedBrick* begin = sorted.data(); begin != end;) {
        const PlacedBrick* const next = std::find_if(
            begin, end, [&](const PlacedBrick& brick) { return brick.cube != begin->cube; });
        Cube& cube = m_cubes[begin->cube];
        cube.nodes.emplace_back();
        add_children(cube, 0, 1, begin, next);
        begin = next;
    }
}

/// @param depth of the node's children: kLevels - 1 for bricks
/// @param begin,end the bricks of a node, by path
template <int kLevels>
void CubeTrees<kLevels>::add_children(Cube& cube, std::size_t node, int depth,
                                      const PlacedBrick* begin, const PlacedBrick* end) {
    const int shift = kChildBits * (kLevels - 1 - depth);
    const auto bit_of = [&](const PlacedBrick& brick) {
        return static_cast<int>(brick.path >> shift & kChildMask);
    };
    for (const PlacedBrick* brick = begin; brick != end; ++brick)
        cube.nodes[node].mask |= std::uint64_t{1} << bit_of(*brick);
    if (depth == kLevels - 1) {
        cube.nodes[node].first = static_cast<std::uint32_t>(cube.bricks.size());
        for (const PlacedBrick* brick = begin; brick != end; ++brick)
            cube.bricks.push_back(brick->mask);
        return;
    }
    std::size_t child = cube.nodes.size();
    cube.nodes[node].first = static_cast<std::uint32_t>(child);
    cube.nodes.resize(child + static_cast<std::size_t>(std::popcount(cube.nodes[node].mask)));
    while (begin != end) {
        const PlacedBrick* const next = std::find_if(
            begin, end, [&](const PlacedBrick& brick) { return bit_of(brick) != bit_of(*begin); });
        add_children(cube, child++, depth + 1, begin, next);
        begin = next;
    }
}

template <int kLevels>
std::size_t CubeTrees<kLevels>::tree_bytes() const noexcept {
    std::size_t out = 0;
    for (const auto& [key, cube] : m_cubes)
        out += cube.nodes.size() * sizeof(Node) + cube.bricks.size() * sizeof(std::uint64_t);
    return out;
}

template <int kLevels>
bool CubeTrees<kLevels>::first_hit(core::RayState& ray) {
    while (true) {
        for (std::size_t a = 0; a < 3; ++a)
            if (ray.forward[a] ? ray.voxel[a] >= m_bounds.max[a] : ray.voxel[a] < m_bounds.min[a])
                return false;
        const auto found = m_cubes.find(
            {0, ray.voxel[0] >> kEdgeBits, ray.voxel[1] >> kEdgeBits, ray.voxel[2] >> kEdgeBits});
        if (found == m_cubes.end()) {
            ++m_steps;
            ray.leap(kEdgeBits);
        } else if (walk_cube(ray, found->second)) {
            return true;
        }
    }
}

/// @return whether the ray is in a solid voxel; otherwise it has left the cube
template <int kLevels>
bool CubeTrees<kLevels>::walk_cube(core::RayState& ray, const Cube& cube) {
    const std::int32_t at[3] = {ray.voxel[0] >> kEdgeBits, ray.voxel[1] >> kEdgeBits,
                                ray.voxel[2] >> kEdgeBits};
    do {
        ++m_steps;
        const std::int32_t x = ray.voxel[0];
        const std::int32_t y = ray.voxel[1];
        const std::int32_t z = ray.voxel[2];
        const Node* node = cube.nodes.data();
        std::uint64_t mask = node->mask;
        int shift = kEdgeBits - 2;
        int bit = voxel::child_bit(x >> shift, y >> shift, z >> shift);
        while ((mask >> bit & 1) != 0) {
            if (shift == 0)
                return true;
            const std::uint32_t child = node->child(bit);
            if (shift == 2) {
                mask = cube.bricks[child];
            } else {
                node = &cube.nodes[child];
                mask = node->mask;
            }
            shift -= 2;
            bit = voxel::child_bit(x >> shift, y >> shift, z >> shift);
        }
        ray.leap(walk::voxel_leap_shift(mask, bit, shift));
    } while (ray.voxel[0] >> kEdgeBits == at[0] && ray.voxel[1] >> kEdgeBits == at[1] &&
             ray.voxel[2] >> kEdgeBits == at[2]);
    return false;
}

template class CubeTrees<2>;
template class CubeTrees<3>;
template class CubeTrees<4>;

}  // namespace terravox::bench
