#include "voxelserver/make/voxelize/steps/ground_fill.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "voxelserver/make/voxelize/steps/scattered.hpp"

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
// an empty one is not due to chance, and the lines of a scanner end so far apart that a narrower
// rim would be a fringe of single columns.
int measure_rim(const Window& window, int radius) {
    const int line_ends = radius / 3;  // 10 m
    return std::min(
        std::max(grid::kPatchSize / std::max(window.patches[4]->cells.side, 1), line_ends), radius);
}

}  // namespace

Coverage find_coverage(const Window& window, const Grid<char, Window::kMargin>& in_bounds,
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
    dilate(outside, radius - measure_rim(window, radius));
    Coverage out(0);
    Coverage::each([&](int x, int z) {
        const auto bit = static_cast<std::size_t>(x + grid::kPatchSize);
        const auto r = static_cast<std::size_t>(z + grid::kPatchSize);
        const bool hole =
            ((seen[r].words[bit / 64] | outside[r].words[bit / 64]) >> (bit % 64) & 1) != 0;
        out.at(x, z) = !hole && in_bounds.at(x, z) != 0 ? 1 : 0;
    });
    return out;
}

Margined<char> straighten_rim(const Coverage& covered, const Grid<char, Window::kMargin>& in_bounds,
                              int radius) {
    std::vector<std::pair<int, int>> around;
    for (int dz = -radius; dz <= radius; ++dz)
        for (int dx = -radius; dx <= radius; ++dx)
            if (dx * dx + dz * dz <= radius * (radius + 1))
                around.emplace_back(dx, dz);
    // Far from every rim, which most patches are, nothing is to be counted.
    const auto [least, most] =
        std::minmax_element(covered.values().begin(), covered.values().end());
    const bool is_even = *least == *most;
    Margined<char> out(0);
    Margined<char>::each([&](int x, int z) {
        if (is_even || in_bounds.at(x, z) == 0) {
            out.at(x, z) = covered.at(x, z);
            return;
        }
        int within = 0;
        int belong = 0;
        for (const auto& [dx, dz] : around) {
            within += in_bounds.at(x + dx, z + dz);
            belong += covered.at(x + dx, z + dz);
        }
        // Lone points, and islets of a few, are no fringe.
        constexpr int kLone = 8;
        const bool is_lone = covered.at(x, z) != 0 && kLone * belong < within;
        out.at(x, z) = is_lone || 2 * belong >= within ? 1 : 0;
    });
    return out;
}

namespace {

constexpr int kReach = 32;  // voxels
constexpr int kRings = 2;   // most gaps between points are no wider
constexpr int kNeeded = 4;  // columns around, on three of four sides

// Which of the four quarters around a column a neighbour lies in; each neighbour lies in exactly
// one.
int quarter(int dx, int dz) noexcept {
    return dx > 0 && dz >= 0 ? 0 : dx <= 0 && dz > 0 ? 1 : dx < 0 && dz <= 0 ? 2 : 3;
}

class GroundFiller {
public:
    GroundFiller(const Window& window, const AskWideGround& wide) : m_window(window), m_wide(wide) {
        // Row by row, in the three segments that lie in one patch each.
        for (int z = Seen::kFirst; z < Seen::kLast; ++z)
            for (const auto& [from, to] : {std::pair{Seen::kFirst, 0},
                                           {0, grid::kPatchSize},
                                           {grid::kPatchSize, Seen::kLast}})
                std::copy_n(&window.patch_at(from, z).ground_height[static_cast<std::size_t>(
                                (z & 63) * grid::kPatchSize + (from & 63))],
                            to - from, &m_seen.at(from, z));
    }

    [[nodiscard]] float seen(int x, int z) const noexcept { return m_seen.at(x, z); }

    float at(int x, int z) {
        const float near = from_rings(x, z);
        if (near == near)
            return near;
        const float across = from_rays(x, z);
        if (across == across)
            return across;
        if (!m_looked)
            find_edges();
        const float far =
            m_edges ? m_edges->at(static_cast<float>(x), static_cast<float>(z), kReach) : kNoHeight;
        return far == far ? far : m_wide(m_window.middle.x0() + x, m_window.middle.z0() + z);
    }

private:
    using Seen = Grid<float, GroundHeights::kMargin + kReach + 1>;
    static_assert(Seen::kMargin <= Window::kMargin);

    /// One place around a column.
    struct Place {
        int offset;
        float weight;
        unsigned side;
    };
    /// Nearest rings first: ring r has 8 r places.
    static const std::vector<Place>& places() {
        static const std::vector<Place> made = [] {
            std::vector<Place> out;
            for (int r = 1; r <= kRings; ++r)
                for (int dz = -r; dz <= r; ++dz)
                    for (int dx = -r; dx <= r; dx += dz == -r || dz == r ? 1 : 2 * r)
                        out.push_back({dz * Seen::kSide + dx,
                                       1.0f / static_cast<float>(dx * dx + dz * dz),
                                       1u << quarter(dx, dz)});
            return out;
        }();
        return made;
    }

    [[nodiscard]] float from_rings(int x, int z) const {
        const float* here = &m_seen.at(x, z);
        auto place = places().begin();
        float sum = 0;
        float weights = 0;
        int count = 0;
        unsigned sides = 0;
        for (int ring = 1; ring <= kRings; ++ring) {
            // Whether a place is known is chance: to add nothing costs less than to guess.
            for (const auto end = place + 8 * ring; place != end; ++place) {
                const float height = here[place->offset];
                const bool known = height == height;
                sum += known ? place->weight * height : 0.0f;
                weights += known ? place->weight : 0.0f;
                count += known ? 1 : 0;
                sides |= known ? place->side : 0;
            }
            if (count >= kNeeded &&
                (sides == 15 || sides == 7 || sides == 11 || sides == 13 || sides == 14))
                return sum / weights;
        }
        return kNoHeight;
    }

    static constexpr std::array<std::pair<int, int>, 8> kDirections = {
        {{-1, 0}, {0, -1}, {-1, -1}, {1, -1}, {1, 0}, {0, 1}, {1, 1}, {-1, 1}}};

    // The nearest ground in eight directions, weighted by distance, where it lies on opposite
    // sides: the ground of a floor between walls.
    [[nodiscard]] float from_rays(int x, int z) {
        if (m_steps[0].empty())
            find_steps();
        const float* here = &m_seen.at(x, z);
        const auto at = static_cast<std::size_t>(here - &m_seen.at(Seen::kFirst, Seen::kFirst));
        float sum = 0;
        float weights = 0;
        unsigned hit = 0;
        for (std::size_t d = 0; d < kDirections.size(); ++d) {
            const int stride = kDirections[d].second * Seen::kSide + kDirections[d].first;
            const int step = m_steps[d][at];
            if (step > kReach)
                continue;
            const float steps = static_cast<float>(step),
                        w = (d % 4 < 2 ? 1.0f : 0.5f) /
                            (steps * steps);  // diagonal steps are longer
            sum += w * here[step * stride];
            weights += w;
            hit |= 1u << d;
        }
        const bool between = (hit & hit >> 4 & 15u) != 0;  // of two opposite directions both
        return between ? sum / weights : kNoHeight;
    }

    // For all columns, how many steps the nearest ground is away in each direction: one more than
    // from the next column that way, unless that one is ground. Rows at a time.
    void find_steps() {
        constexpr std::uint8_t kNone = kReach + 1;
        constexpr auto kSide = static_cast<std::size_t>(Seen::kSide);
        const float* seen = &m_seen.at(Seen::kFirst, Seen::kFirst);
        std::vector<std::uint8_t> gap(kSide * kSide);
        for (std::size_t i = 0; i < gap.size(); ++i)
            gap[i] = seen[i] == seen[i] ? 0 : UINT8_MAX;
        for (std::size_t d = 0; d < kDirections.size(); ++d) {
            const auto [dx, dz] = kDirections[d];
            std::vector<std::uint8_t>& steps = m_steps[d];
            steps.assign(kSide * kSide, kNone);
            const std::ptrdiff_t stride = dz * Seen::kSide + dx;
            for (std::size_t row = 1; row + 1 < kSide; ++row) {
                std::uint8_t* to = &steps[(dz > 0 ? kSide - 1 - row : row) * kSide];
                const std::uint8_t* from = to + stride;
                const std::uint8_t* between = gap.data() + (from - steps.data());
                const auto after = [&](std::size_t x, std::uint8_t next) {
                    return std::min<std::uint8_t>((between[x] & next) + 1, kNone);
                };
                // Along a row each waits for the one before: not by way of memory.
                std::uint8_t last = kNone;
                if (dz != 0)
                    for (std::size_t x = 1; x + 1 < kSide; ++x)
                        to[x] = after(x, from[x]);
                else if (dx > 0)
                    for (std::size_t x = kSide - 1; x-- > 1;)
                        to[x] = last = after(x, last);
                else
                    for (std::size_t x = 1; x + 1 < kSide; ++x)
                        to[x] = last = after(x, last);
            }
        }
    }

    // Only ground columns next to a gap: the nearest ones to any place inside the gap are among
    // them, and they surround it evenly.
    void find_edges() {
        m_looked = true;
        std::vector<ScatteredHeights::Sample> edges;
        constexpr int kFar = GroundHeights::kMargin + kReach;
        for (int z = -kFar; z < grid::kPatchSize + kFar; ++z)
            for (int x = -kFar; x < grid::kPatchSize + kFar; ++x) {
                const float* here = &m_seen.at(x, z);
                // A sum with a NaN is NaN: all four neighbours at once.
                const float around = here[-1] + here[1] + here[-Seen::kSide] + here[Seen::kSide];
                if (*here == *here && around != around)
                    edges.push_back({static_cast<float>(x), static_cast<float>(z), *here});
            }
        if (!edges.empty())
            m_edges = std::make_unique<ScatteredHeights>(std::move(edges));
    }

    const Window& m_window;
    const AskWideGround& m_wide;
    Seen m_seen;
    /// By direction; empty until a column is not filled by its rings.
    std::array<std::vector<std::uint8_t>, 8> m_steps;
    bool m_looked = false;
    std::unique_ptr<ScatteredHeights> m_edges;  // made when the first wide gap is met
};

}  // namespace

GroundHeights fill_ground(const Window& window, const Grid<char, GroundHeights::kMargin>& wanted,
                          const AskWideGround& wide) {
    GroundHeights out;
    GroundFiller filler(window, wide);
    GroundHeights::each([&](int x, int z) {
        const float height = filler.seen(x, z);
        out.at(x, z) = height != height && wanted.at(x, z) != 0 ? filler.at(x, z) : height;
    });
    return out;
}

GroundHeights seen_ground(const Window& window) {
    GroundHeights out;
    GroundHeights::each([&](int x, int z) { out.at(x, z) = window.column(x, z).ground.height; });
    return out;
}

}  // namespace terravox::voxelize
