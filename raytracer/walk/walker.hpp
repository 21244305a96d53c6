#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>

#include "common/voxel/box.hpp"
#include "raytracer/walk/block_reader.hpp"
#include "raytracer/walk/ray.hpp"

namespace terravox {

/// An integer voxel of the walker's level.
struct VoxelCoord {
    std::int32_t x = 0, y = 0, z = 0;
    [[nodiscard]] std::int32_t operator[](int axis) const noexcept { return axis == 0 ? x : axis == 1 ? y : z; }
    friend bool operator==(const VoxelCoord&, const VoxelCoord&) = default;
};

struct Hit {
    double t = 0;  ///< multiples of the ray's direction, to the face (0 when the ray starts inside)
    VoxelCoord voxel;
    Face face = Face::kNone;  ///< the face the ray came through; kNone when it starts inside
    voxel::VoxelAttr attr;
    bool hole = false;  ///< not a voxel: a box that could not be had
};

/// What a walk stops at.
enum class StopAt {
    kSolid,       ///< anything but air
    kNotWater,    ///< anything but air and water: what a swimmer sees
};

/// Walks rays through boxes of one level to the first voxel that stops them.
///
/// Amanatides-Woo with a change of level: from box grid to 64^3, 16^3, 4^3 cells and voxels, always leaping over the largest empty
/// cell. Every crossing is computed as (plane - origin) / direction, never summed up, and ties go to x before y before z, so that a
/// leap ends in exactly the voxel that single steps would have reached: no epsilon, no drift however long the ray.
/// Coordinates: voxels of the reader's level. Not thread-safe (the reader is not).
/// Ref: Amanatides & Woo, "A Fast Voxel Traversal Algorithm", Eurographics 1987; Museth, "Hierarchical Digital Differential
/// Analyzer", SIGGRAPH Talks 2014.
class Walker {
public:
    /// @param bounds nothing solid lies outside, voxels of the reader's level
    Walker(BlockReader& reader, const voxel::VoxelBounds& bounds) : m_reader(reader), m_bounds(bounds) {}

    /// The first voxel that stops the ray with t in [0, t_max].
    [[nodiscard]] std::optional<Hit> first_hit(const Ray& ray, StopAt stop = StopAt::kSolid, double t_max = kFar);

    /// The same for a ray that starts on a face: `start` is the voxel it starts in, whatever rounding says of its origin.
    [[nodiscard]] std::optional<Hit> first_hit_from(const Ray& ray, VoxelCoord start, StopAt stop = StopAt::kSolid, double t_max = kFar);

    [[nodiscard]] std::uint64_t rays() const noexcept { return m_rays; }
    [[nodiscard]] std::uint64_t steps() const noexcept { return m_steps; }

    static constexpr double kFar = std::numeric_limits<double>::infinity();

private:
    struct State;
    [[nodiscard]] bool enter(State& s) const noexcept;
    [[nodiscard]] std::optional<Hit> walk(State& s, StopAt stop, double t_max);
    BlockReader& m_reader;
    voxel::VoxelBounds m_bounds;
    std::uint64_t m_rays = 0, m_steps = 0;
};

}  // namespace terravox
