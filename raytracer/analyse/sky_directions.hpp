#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/voxel/colour.hpp"
#include "raytracer/core/ray.hpp"

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
/// directions by solid angle. A set is a lattice of rank 1, shifted; the sets differ by their
/// shifts, so that neighbouring cells err differently and means over cells converge.
/// Ref: Yokoyama, Shirasawa, Pike, "Visualizing topography by openness", 2002; Cranley & Patterson,
/// "Randomization of number theoretic methods for multiple integration", 1976. Immutable.
class SkyDirections {
public:
    /// @param count directions of a set, at least 2
    explicit SkyDirections(int count);
    /// @param cell any number that identifies a cell; the same number gives the same set
    [[nodiscard]] std::span<const SkyDirection> of(std::uint64_t cell) const noexcept;

private:
    static constexpr std::size_t kSets = 64;
    std::size_t m_count;
    std::vector<SkyDirection> m_directions;
};

}  // namespace terravox::analyse
