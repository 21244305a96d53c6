#pragma once

#include <cstdint>

#include "raytracer/analyse/evaluators/cell_evaluator.hpp"
#include "raytracer/analyse/evaluators/plane_light.hpp"
#include "raytracer/core/base/ray.hpp"
#include "raytracer/core/base/scene_words.hpp"

namespace terravox::analyse {

/// Towards the outside of a wall; x east, z south.
[[nodiscard]] core::Vec3 to_direction(core::WallSide side) noexcept;

/// Which cells around one are as high as it: a window of 7 x 7 cells, seen as a disc.
class WallOutline {
public:
    static constexpr int kEdge = 7;
    static constexpr int kRadius = kEdge / 2;
    static constexpr std::uint32_t kCells = kEdge * kEdge;
    static constexpr std::uint32_t kOfCell = kCells / 2;  ///< the place of the cell itself

    WallOutline() noexcept { add(kOfCell); }
    /// From bits().
    explicit WallOutline(std::uint64_t bits) noexcept : m_bits(bits) {}

    /// Steps of a place, row by row from the north-west, from the cell.
    [[nodiscard]] static int find_east(std::uint32_t place) noexcept;
    [[nodiscard]] static int find_south(std::uint32_t place) noexcept;
    /// Whether a place belongs to the disc. The others need not be known.
    [[nodiscard]] static bool is_near(std::uint32_t place) noexcept;

    void add(std::uint32_t place) noexcept { m_bits |= std::uint64_t{1} << place; }
    [[nodiscard]] bool has(std::uint32_t place) const noexcept {
        return ((m_bits >> place) & 1) != 0;
    }
    [[nodiscard]] std::uint64_t bits() const noexcept { return m_bits; }

    /// The normal of the wall, of unit length and level: that of the straight lines that part the
    /// cells of the disc best into those of the cell's building, which are connected with it by
    /// sides or corners, and the others. Of many lines that are as good it is the mean. Cells of a
    /// half plane give its normal, whatever its angle to the grid, within some degrees. Where the
    /// whole disc has no such line, as at the corner of a building, the half of it along the wall
    /// that has one decides.
    /// @param side of the cell at which the wall is; the normal is less than 76 degrees off it
    [[nodiscard]] core::Vec3 normal(core::WallSide side) const noexcept;

private:
    [[nodiscard]] std::uint64_t connected() const noexcept;

    std::uint64_t m_bits = 0;
};

/// Measures core::FacadeBand: the light on one storey of the wall between a cell of a building and
/// its lower neighbour on the side that the scene names.
///
/// Vertical rays find the top of the building and, in the neighbouring cell, the foot of the wall,
/// both below crowns. A level ray from the middle of the neighbouring cell tells whether there is a
/// wall at the storey's height. Rays around the cell find the outline of the building there, whose
/// normal is that of the wall: walls of voxels are stairs. From the start of the level ray the
/// light is gathered (PlaneLight). A cell's values depend on no other cell's.
class FacadeEvaluator final : public CellEvaluator {
public:
    explicit FacadeEvaluator(const shade::View& view) noexcept;

    void shade(const walk::TracedRay& ray, shade::SampleSum& sum,
               std::vector<walk::TracedRay>& next) const override;
    [[nodiscard]] walk::FanDirections directions(std::uint32_t stream) const override {
        return m_light.directions(stream);
    }
    void shade_fan(const walk::TracedRay& fan, walk::FanEnds ends, shade::SampleSum& sum,
                   std::vector<walk::TracedRay>& next) const override;

private:
    void shade_cell(const walk::TracedRay& ray, shade::SampleSum& sum,
                    std::vector<walk::TracedRay>& next) const;
    void shade_foot(const walk::TracedRay& ray, shade::SampleSum& sum,
                    std::vector<walk::TracedRay>& next) const;
    void shade_wall(const walk::TracedRay& ray, shade::SampleSum& sum,
                    std::vector<walk::TracedRay>& next) const;
    void shade_around(const walk::TracedRay& ray, shade::SampleSum& sum,
                      std::vector<walk::TracedRay>& next) const;
    /// Makes a wall's values of its light.
    /// @param middle height of the middle of the storey's wall, level-0 voxels
    void finish_if(bool is_complete, double middle, shade::SampleSum& sum) const noexcept;

    const shade::View& m_view;
    const core::WallSide m_side;
    const core::Vec3 m_outwards;  ///< to_direction(m_side)
    const double m_spacing;       ///< of cells, level-0 voxels
    const double m_storey;        ///< height of one, level-0 voxels
    const PlaneLight m_light;
};

}  // namespace terravox::analyse
