#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "common/voxel/world.hpp"

namespace terravox::exports {

/// A rectangle of columns of boxes, half-open.
struct ColumnBlock {
    std::int32_t min_bx = 0;
    std::int32_t min_bz = 0;
    std::int32_t max_bx = 0;
    std::int32_t max_bz = 0;
    friend bool operator==(const ColumnBlock&, const ColumnBlock&) = default;
};
[[nodiscard]] inline ColumnBlock to_block(const voxel::BoxRange& range) noexcept {
    return {range.min.bx, range.min.bz, range.max.bx, range.max.bz};
}

/// The columns of boxes of a part that may hold anything, one after the other: squares of `edge` x
/// `edge` columns row by row from the north-west, and within a square row by row, so that
/// neighbours follow each other closely. Empty squares are skipped without a test of each of them:
/// a world may be as wide as the Earth, and hold a village.
class Columns {
public:
    struct At {
        std::int32_t bx = 0;
        std::int32_t bz = 0;
        std::size_t square = 0;  ///< number of its square, rising
    };
    /// Whether a rectangle of columns may hold anything: cheap, with false positives only.
    using MayHold = std::function<bool(const ColumnBlock&)>;

    static constexpr std::size_t kMaxSquares = std::size_t{1} << 24;

    /// @throws UsageError for more than kMaxSquares squares that may hold anything
    Columns(const ColumnBlock& of, std::size_t edge, const MayHold& may_hold);

    [[nodiscard]] std::size_t count() const noexcept { return m_count; }
    [[nodiscard]] At at(std::size_t i) const noexcept;
    /// Number of columns that are left out.
    [[nodiscard]] std::uint64_t left_out() const noexcept {
        return static_cast<std::uint64_t>(m_width) * m_depth - m_count;
    }
    /// The squares, in their order; those at the edges of the part are cut off there.
    [[nodiscard]] std::vector<ColumnBlock> squares() const;

private:
    struct Square {
        std::uint32_t row = 0;
        std::uint32_t column = 0;
        std::uint64_t first = 0;  ///< number of its first column
    };
    struct Squares;  ///< a rectangle of squares
    [[nodiscard]] std::size_t squares_across() const noexcept {
        return (m_width + m_edge - 1) / m_edge;
    }
    [[nodiscard]] std::size_t squares_down() const noexcept {
        return (m_depth + m_edge - 1) / m_edge;
    }
    [[nodiscard]] ColumnBlock to_block(const Squares& squares) const noexcept;
    void find(const Squares& squares, const MayHold& may_hold);

    ColumnBlock m_of;
    std::size_t m_edge;
    std::size_t m_width;
    std::size_t m_depth;
    std::size_t m_count = 0;
    std::vector<Square> m_squares;
};

}  // namespace terravox::exports
