#pragma once

#include <array>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "common/voxel/world.hpp"
#include "raytracer/core/ray_state.hpp"

namespace terravox::bench {

/// 4 x 4 x 4 voxels of which some are solid; bits as voxel::child_bit().
struct Brick {
    core::VoxelCoord at;  ///< in bricks
    std::uint64_t mask = 0;
};

/// All bricks of a world that are not empty, at level 0.
[[nodiscard]] std::vector<Brick> bricks_of(voxel::World& world);

/// The solid voxels of a world in cubes of 4^kLevels voxels a side, each a 64-tree of kLevels
/// levels, looked up by the hash of their Morton code: what the boxes of the program would be in
/// another size. Without materials.
template <int kLevels>
class CubeTrees {
public:
    static constexpr int kEdgeBits = 2 * kLevels;
    static constexpr int kEdge = 1 << kEdgeBits;

    /// @param bricks each once
    CubeTrees(const std::vector<Brick>& bricks, const voxel::VoxelBounds& bounds);

    /// Walks a ray that is in a voxel of level 0 until it is in a solid one.
    /// @return false when it has left the bounds
    [[nodiscard]] bool first_hit(core::RayState& ray);

    [[nodiscard]] std::size_t cubes() const noexcept { return m_cubes.size(); }
    /// Of all trees, without the table of cubes.
    [[nodiscard]] std::size_t tree_bytes() const noexcept;
    /// Cells and voxels visited so far.
    [[nodiscard]] std::uint64_t steps() const noexcept { return m_steps; }

private:
    /// Children that hold anything, and where the first of them is: a node, or the mask of a brick.
    struct Node {
        std::uint64_t mask = 0;
        std::uint32_t first = 0;
        [[nodiscard]] std::uint32_t child(int bit) const noexcept;
    };
    struct Cube {
        std::vector<Node> nodes;  ///< the root is the first
        std::vector<std::uint64_t> bricks;
    };
    /// A brick by its path from the root: six bits a level.
    struct PlacedBrick {
        voxel::BoxKey cube;
        std::uint32_t path = 0;
        std::uint64_t mask = 0;
    };

    [[nodiscard]] static PlacedBrick placed(const Brick& brick) noexcept;
    static void add_children(Cube& cube, std::size_t node, int depth, const PlacedBrick* begin,
                             const PlacedBrick* end);
    [[nodiscard]] bool walk_cube(core::RayState& ray, const Cube& cube);

    voxel::VoxelBounds m_bounds;
    std::unordered_map<voxel::BoxKey, Cube, voxel::BoxKeyHash> m_cubes;
    std::uint64_t m_steps = 0;
};

extern template class CubeTrees<2>;
extern template class CubeTrees<3>;
extern template class CubeTrees<4>;

}  // namespace terravox::bench
