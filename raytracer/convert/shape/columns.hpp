#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "common/voxel/world.hpp"

namespace terravox::convert {

/// A rectangle of columns of boxes, half-open.
struct ColumnBlock {
    std::int32_t min_bx = 0, min_bz = 0, max_bx = 0, max_bz = 0;
    friend bool operator==(const ColumnBlock&, const ColumnBlock&) = default;
};

/// The columns of boxes of a part one after the other: squares of `edge` x `edge` columns row by row from the north-west, and within a square
/// row by row, so that neighbours come soon after each other.
class Columns {
public:
    struct At {
        std::int32_t bx = 0, bz = 0;
        std::size_t square = 0;  ///< number of its square, rising
    };

    Columns(const ColumnBlock& of, std::size_t edge)
        : m_of(of), m_edge(edge), m_width(static_cast<std::size_t>(std::int64_t{of.max_bx} - of.min_bx)),
          m_depth(static_cast<std::size_t>(std::int64_t{of.max_bz} - of.min_bz)) {}
    Columns(const voxel::BoxRange& of, std::size_t edge) : Columns(ColumnBlock{of.min.bx, of.min.bz, of.max.bx, of.max.bz}, edge) {}

    [[nodiscard]] std::size_t count() const noexcept { return m_width * m_depth; }
    [[nodiscard]] std::size_t squares() const noexcept { return squares_across() * ((m_depth + m_edge - 1) / m_edge); }
    [[nodiscard]] At at(std::size_t i) const noexcept {
        const std::size_t strip = i / (m_width * m_edge), rows = std::min(m_edge, m_depth - strip * m_edge);
        const std::size_t in_strip = i - strip * m_width * m_edge, square = in_strip / (m_edge * rows);
        const std::size_t in_square = in_strip - square * m_edge * rows, across = std::min(m_edge, m_width - square * m_edge);
        return {m_of.min_bx + static_cast<std::int32_t>(square * m_edge + in_square % across),
                m_of.min_bz + static_cast<std::int32_t>(strip * m_edge + in_square / across), strip * squares_across() + square};
    }

private:
    [[nodiscard]] std::size_t squares_across() const noexcept { return (m_width + m_edge - 1) / m_edge; }
    ColumnBlock m_of;
    std::size_t m_edge, m_width, m_depth;
};

}  // namespace terravox::convert
