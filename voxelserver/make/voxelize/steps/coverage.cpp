#include "voxelserver/make/voxelize/steps/coverage.hpp"

#include <algorithm>
#include <array>
#include <vector>

namespace terravox::voxelize {
namespace {

/// One row of a window as bits, west to east: bit i = column i - 64.
struct Row {
    std::array<std::uint64_t, 3> words{};

    [[nodiscard]] Row shifted_east(int by) const noexcept {  // by in 1..63; zeros come in
        return {{words[0] << by, words[1] << by | words[0] >> (64 - by),
                 words[2] << by | words[1] >> (64 - by)}};
    }
    [[nodiscard]] Row shifted_west(int by) const noexcept {
        return {{words[0] >> by | words[1] << (64 - by), words[1] >> by | words[2] << (64 - by),
                 words[2] >> by}};
    }
    Row& operator|=(const Row& o) noexcept {
        for (std::size_t i = 0; i < 3; ++i)
            words[i] |= o.words[i];
        return *this;
    }
};
using Rows = std::vector<Row>;
constexpr std::size_t kRows = 3 * grid::kPatchSize;

// Calls widen(step) until the steps add up to the radius, doubling them: each one widens the result
// of the previous ones.
template <class Widen>
void in_doubling_steps(int radius, const Widen& widen) {
    for (int done = 0, step = 1; done < radius; done += step) {
        step = std::min(done == 0 ? 1 : done + 1, radius - done);
        widen(step);
    }
}

void dilate(Rows& rows, int radius) {
    for (Row& row : rows) {
        Row east = row;
        Row west = row;
        in_doubling_steps(radius, [&](int step) {
            east |= east.shifted_east(step);
            west |= west.shifted_west(step);
        });
        row |= east;
        row |= west;
    }
    Rows south = rows;
    Rows north = rows;
    in_doubling_steps(radius, [&](int step) {
        const auto s = static_cast<std::size_t>(step);
        for (std::size_t i = kRows; i-- > s;)
            south[i] |= south[i - s];
        for (std::size_t i = 0; i + s < kRows; ++i)
            north[i] |= north[i + s];
    });
    for (std::size_t i = 0; i < kRows; ++i) {
        rows[i] |= south[i];
        rows[i] |= north[i];
    }
}

// How far beyond the outermost return the land still counts as seen: a water cell is so large that
// an empty one is not due to chance.
int rim_of(const Window& window, int radius) {
    constexpr int kMin = 2;  // a header that ends on whole metres
    return std::min(std::max(grid::kPatchSize / std::max(window.patches[4]->cells.side, 1), kMin),
                    radius);
}

}  // namespace

Margined<char> find_coverage(const Window& window, const Grid<char, Window::kMargin>& in_bounds,
                             int radius) {
    Rows seen(kRows), inside(kRows);
    for (int z = -grid::kPatchSize; z < 2 * grid::kPatchSize; ++z) {
        const auto r = static_cast<std::size_t>(z + grid::kPatchSize);
        for (std::size_t w = 0; w < 3; ++w) {
            const int x0 = static_cast<int>(w) * grid::kPatchSize - grid::kPatchSize;
            for (int x = 0; x < grid::kPatchSize; ++x)
                inside[r].words[w] |= std::uint64_t{in_bounds.at(x0 + x, z) != 0} << x;
            seen[r].words[w] = window.patch_at(x0, z).occupied[static_cast<std::size_t>(z & 63)] &
                               inside[r].words[w];
        }
    }
    // A column is a hole when some empty square holds it. Squares around places outside the bounds
    // must keep the rim's distance from it: otherwise they would open the rim of every survey, and
    // without them at all a void at the edge would close as if there were returns beyond.
    dilate(seen, radius);
    Rows outside(kRows);
    for (std::size_t i = 0; i < kRows; ++i)
        for (std::size_t w = 0; w < 3; ++w) {
            outside[i].words[w] = ~seen[i].words[w] & ~inside[i].words[w];
            seen[i].words[w] = ~seen[i].words[w] & inside[i].words[w];
        }
    dilate(seen, radius);
    dilate(outside, radius - rim_of(window, radius));
    Margined<char> out(0);
    Margined<char>::each([&](int x, int z) {
        const auto bit = static_cast<std::size_t>(x + grid::kPatchSize);
        const auto r = static_cast<std::size_t>(z + grid::kPatchSize);
        const bool hole =
            ((seen[r].words[bit / 64] | outside[r].words[bit / 64]) >> (bit % 64) & 1) != 0;
        out.at(x, z) = !hole && in_bounds.at(x, z) != 0 ? 1 : 0;
    });
    return out;
}

}  // namespace terravox::voxelize
