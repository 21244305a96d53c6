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

/// Measures core::SkyBand: from the middle of each cell's top, or of its ground, rays in all
/// directions of the upper half of a sphere. A voxel of any material blocks them, leaves and panes
/// as well; what lies outside of the world's bounds does not.
class SkyEvaluator final : public CellEvaluator {
public:
    explicit SkyEvaluator(const shade::View& view);

    void shade(const walk::TracedRay& ray, shade::SampleSum& sum,
               std::vector<walk::TracedRay>& next) const override;
    [[nodiscard]] walk::FanDirections directions(std::uint32_t stream) const override;
    void shade_fan(const walk::TracedRay& fan, walk::FanEnds ends, shade::SampleSum& sum,
                   std::vector<walk::TracedRay>& next) const override;

private:
    /// A part of a set of directions.
    struct Part {
        std::size_t set;
        std::size_t first;  ///< direction of the set
        std::size_t end;
    };
    /// The part that fans of a stream look at.
    [[nodiscard]] Part find_part(std::uint32_t stream) const noexcept;
    void send_to_sky(const FanStart& start, std::size_t set, std::size_t first,
                     std::vector<walk::TracedRay>& next) const;
    const shade::View& m_view;
    const SkyDirections m_directions;
    const std::uint32_t m_fans;  ///< of a set
    const double m_range;        ///< level-0 voxels
};

}  // namespace terravox::analyse
