#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace terravox::sunlight {

/// What a cell tells those around it.
struct BrightCell {
    enum class As : std::uint8_t { kNothing, kLit, kShadow };
    float light = 0;  ///< luminance; of what lies in the sun, as it would be on flat ground
    As as = As::kNothing;
};

/// Sums over the square of cells around each cell, made for all of them together: windows of 1, 2,
/// 4, 8 cells are combined, along rows and then along columns.
class BrightnessAround {
public:
    struct Sums {
        float lit = 0;
        float brightest_lit = 0;
        float lit_count = 0;
        float shadow = 0;
        float shadow_count = 0;
    };

    /// @param width of a row
    /// @param reach of a square: so many cells to each side
    /// @param cells row by row; those that say nothing do not count
    BrightnessAround(int width, int reach, const std::vector<BrightCell>& cells);

    /// @param x,z at least `reach` cells from the edges
    [[nodiscard]] Sums at(int x, int z) const noexcept;

private:
    using Plane = std::vector<float>;  ///< by the first cell of a square
    template <class Combine>
    [[nodiscard]] Plane over_squares(const Plane& values, const Combine& combine) const;

    std::size_t m_width;
    std::size_t m_reach;
    Plane m_lit;
    Plane m_brightest_lit;
    Plane m_lit_count;
    Plane m_shadow;
    Plane m_shadow_count;
};

}  // namespace terravox::sunlight
