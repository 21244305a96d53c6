#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/voxel/colour.hpp"
#include "raytracer/analyse/evaluators/cell_evaluator.hpp"
#include "raytracer/core/base/ray.hpp"

namespace terravox::analyse {

/// A direction towards the sky, and its share of each of the three measures.
struct SkyDirection {
    core::Vec3 to;  ///< of unit length, y > 0
    /// r: by the cosine of the zenith angle, g: by solid angle, b: by zenith angle. Over all
    /// directions of a set each adds up to 1.
    voxel::Colour share;
};

/// Sets of directions over the upper half of a sphere, evenly spread over azimuth and zenith angle.
///
/// One set serves three measures: of the sky's zenith angles, uniform ones give openness directly
/// (the mean free angle), and the other two by weights, with less noise at steep walls than
/// directions by solid angle. A set is a lattice of rank 1, shifted. All sets together are one
/// finer lattice, so that neighbouring cells err differently and means over cells converge; there
/// are few, so that many cells of a wave have a set in common, and their rays are traced together.
/// Ref: Yokoyama, Shirasawa, Pike, "Visualizing topography by openness", 2002; Sloan & Joe,
/// "Lattice Methods for Multiple Integration", 1994. Immutable.
class SkyDirections {
public:
    /// @param count directions of a set, at least 2
    explicit SkyDirections(int count);
    /// The set of a cell, below kSets.
    /// @param cell any number that identifies a cell; the same number gives the same set
    [[nodiscard]] static std::size_t choose_set(std::uint64_t cell) noexcept;
    [[nodiscard]] std::span<const SkyDirection> of(std::size_t set) const noexcept;
    [[nodiscard]] std::size_t count() const noexcept { return m_count; }

    static constexpr std::size_t kSets = 8;

private:
    std::size_t m_count;
    std::vector<SkyDirection> m_directions;
};

}  // namespace terravox::analyse
