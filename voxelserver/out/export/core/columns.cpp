#include "voxelserver/out/export/core/columns.hpp"

#include <tuple>

#include "common/util/error.hpp"

namespace terravox::exports {

struct Columns::Squares {
    std::size_t min_column;
    std::size_t min_row;
    std::size_t max_column;
    std::size_t max_row;
    [[nodiscard]] std::size_t across() const noexcept { return max_column - min_column; }
    [[nodiscard]] std::size_t down() const noexcept { return max_row - min_row; }
};

Columns::Columns(const ColumnBlock& of, std::size_t edge, const MayHold& may_hold)
    : m_of(of),
      m_edge(edge),
      m_width(static_cast<std::size_t>(std::int64_t{of.max_bx} - of.min_bx)),
      m_depth(static_cast<std::size_t>(std::int64_t{of.max_bz} - of.min_bz)) {
    find({0, 0, squares_across(), squares_down()}, may_hold);
    std::sort(m_squares.begin(), m_squares.end(), [](const Square& a, const Square& b) {
        return std::tie(a.row, a.column) < std::tie(b.row, b.column);
    });
    for (Square& s : m_squares) {
        s.first = m_count;
        const ColumnBlock block = to_block({s.column, s.row, s.column + 1, s.row + 1});
        m_count += static_cast<std::size_t>(block.max_bx - block.min_bx) *
                   static_cast<std::size_t>(block.max_bz - block.min_bz);
    }
}

ColumnBlock Columns::to_block(const Squares& squares) const noexcept {
    const auto at = [&](std::int32_t from, std::size_t square, std::size_t most) {
        return static_cast<std::int32_t>(
            from + static_cast<std::int64_t>(std::min(square * m_edge, most)));
    };
    return {at(m_of.min_bx, squares.min_column, m_width), at(m_of.min_bz, squares.min_row, m_depth),
            at(m_of.min_bx, squares.max_column, m_width),
            at(m_of.min_bz, squares.max_row, m_depth)};
}

void Columns::find(const Squares& squares, const MayHold& may_hold) {
    if (squares.across() == 0 || squares.down() == 0 || !may_hold(to_block(squares)))
        return;
    if (squares.across() == 1 && squares.down() == 1) {
        if (m_squares.size() == kMaxSquares)
            throw util::UsageError(
                "convert: the part has more than " + std::to_string(kMaxSquares) + " squares of " +
                std::to_string(m_edge) + " x " + std::to_string(m_edge) +
                " columns of boxes in which something may stand; allowed: a smaller"
                " --area, or a coarser --level");
        m_squares.push_back({static_cast<std::uint32_t>(squares.min_row),
                             static_cast<std::uint32_t>(squares.min_column), 0});
        return;
    }
    Squares one = squares;
    Squares other = squares;
    if (squares.across() >= squares.down())
        one.max_column = other.min_column = squares.min_column + squares.across() / 2;
    else
        one.max_row = other.min_row = squares.min_row + squares.down() / 2;
    find(one, may_hold);
    find(other, may_hold);
}

Columns::At Columns::at(std::size_t i) const noexcept {
    const auto after = std::upper_bound(m_squares.begin(), m_squares.end(), i,
                                        [](std::size_t n, const Square& s) { return n < s.first; });
    const Square& square = *(after - 1);
    const ColumnBlock block =
        to_block({square.column, square.row, square.column + 1u, square.row + 1u});
    const std::size_t in_square = i - square.first;
    const auto across = static_cast<std::size_t>(block.max_bx - block.min_bx);
    return {block.min_bx + static_cast<std::int32_t>(in_square % across),
            block.min_bz + static_cast<std::int32_t>(in_square / across),
            square.row * squares_across() + square.column};
}

std::vector<ColumnBlock> Columns::squares() const {
    std::vector<ColumnBlock> out;
    out.reserve(m_squares.size());
    for (const Square& s : m_squares)
        out.push_back(to_block({s.column, s.row, s.column + 1u, s.row + 1u}));
    return out;
}

}  // namespace terravox::exports
