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

}  // namespace terravox::analyse
