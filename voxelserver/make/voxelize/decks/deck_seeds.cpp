#include "voxelserver/make/voxelize/decks/deck_section.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <vector>

namespace terravox::voxelize {
namespace {

constexpr int kFall = 3;  // columns within which an edge drops, however it lies to the rows
// Longest cut along rows or lines, whichever is shorter, of a deck that lies across them.
constexpr double kSkewed = 1.4142136;
// The same along diagonals, at most 22.5 degrees oblique, in steps of 1.41 columns.
constexpr double kSkewedDiagonal = 0.7653669;
constexpr int kMaxChord = 31;
constexpr int kMaxMargin = DeckSeeds::kMargin + kMaxChord + kFall;
static_assert(kMaxMargin + 2 <= Window::kMargin);
constexpr int kSide = grid::kPatchSize + 2 * kMaxMargin;
constexpr float kLow = -1e9F;     // water and voids: lower than any land
constexpr float kUnknown = 1e9F;  // no lower than anything

// One row of a window, west to east: bit i = column i - 64.
using Bits = std::array<std::uint64_t, 3>;

Bits east(const Bits& b, int by) noexcept {
    return {b[0] << by, b[1] << by | b[0] >> (64 - by), b[2] << by | b[1] >> (64 - by)};
}
Bits west(const Bits& b, int by) noexcept {
    return {b[0] >> by | b[1] << (64 - by), b[1] >> by | b[2] << (64 - by), b[2] >> by};
}
Bits operator&(const Bits& a, const Bits& b) noexcept {
    return {a[0] & b[0], a[1] & b[1], a[2] & b[2]};
}
Bits operator|(const Bits& a, const Bits& b) noexcept {
    return {a[0] | b[0], a[1] | b[1], a[2] | b[2]};
}
Bits operator~(const Bits& a) noexcept {
    return {~a[0], ~a[1], ~a[2]};
}
bool any(const Bits& b) noexcept {
    return (b[0] | b[1] | b[2]) != 0;
}

using Rows = std::array<Bits, 3 * grid::kPatchSize>;  // index z + 64

Rows make_rows(const Window& window,
               std::array<std::uint64_t, grid::kPatchSize> PatchColumns::* what) {
    Rows out;
    for (std::size_t i = 0; i < out.size(); ++i)
        for (std::size_t w = 0; w < 3; ++w)
            out[i][w] = (*window.patches[i / grid::kPatchSize * 3 + w].*what)[i % grid::kPatchSize];
    return out;
}

// Voids at least three columns wide and long: single columns are often missed.
Rows wide_voids(const Rows& occupied) {
    Rows narrow{};
    Rows eroded{};
    Rows out{};
    for (std::size_t i = 0; i < out.size(); ++i) {
        const Bits b = ~occupied[i];
        narrow[i] = b & east(b, 1) & west(b, 1);
    }
    for (std::size_t i = 1; i + 1 < out.size(); ++i) {
        const Bits b = narrow[i - 1] & narrow[i] & narrow[i + 1];
        eroded[i] = b | east(b, 1) | west(b, 1);
    }
    for (std::size_t i = 1; i + 1 < out.size(); ++i)
        out[i] = eroded[i - 1] | eroded[i] | eroded[i + 1];
    return out;
}

class SeedFinder {
public:
    SeedFinder(const Window& window, const DeckLimits& limits)
        : m_drop(limits.drop),
          m_chord(std::min(kMaxChord, static_cast<int>(std::lround(limits.widest * kSkewed)) + 1)),
          m_diagonal(static_cast<int>(std::lround(limits.widest * kSkewedDiagonal)) + 1),
          m_first(-DeckSeeds::kMargin - m_chord - kFall),
          m_last(grid::kPatchSize - m_first) {
        read_heights(window);
        const Rows occupied = make_rows(window, &PatchColumns::occupied);
        const Rows wet = make_rows(window, &PatchColumns::wet);
        const Rows ground = make_rows(window, &PatchColumns::ground);
        const Rows built = make_rows(window, &PatchColumns::built);
        m_low = wide_voids(occupied);
        add_water(occupied, wet);
        for (std::size_t i = 0; i < m_low.size(); ++i) {
            m_thing[i] = occupied[i] & ~built[i] & ~wet[i] & ~ground[i];
        }
        for (int z = m_first; z < m_last; ++z) {
            const Bits& row = m_low[static_cast<std::size_t>(z + grid::kPatchSize)];
            if (any(row))
                set(row, &at(m_first, z), kLow);
        }
    }

    std::optional<DeckSeeds> find() {
        Marks drops(static_cast<std::size_t>(kSide * kSide));
        const bool rows = along_rows(drops);
        const bool lines = along_lines(0, m_chord, nullptr, drops);
        if (!rows && !lines)
            return std::nullopt;
        // Near the ends of an oblique deck, neither row nor line leads across it.
        along_lines(1, m_diagonal, &drops, drops);
        along_lines(-1, m_diagonal, &drops, drops);
        if (!m_any)
            return std::nullopt;
        return std::move(m_seeds);
    }

private:
    using Flags = std::array<std::uint8_t, kSide>;
    using Marks = std::vector<std::uint8_t>;  // as m_heights

    [[nodiscard]] float& at(int x, int z) noexcept {
        return m_heights[static_cast<std::size_t>((z - m_first) * kSide + x - m_first)];
    }
    [[nodiscard]] int count() const noexcept { return m_last - m_first; }

    void read_heights(const Window& window) {
        m_heights.assign(static_cast<std::size_t>(kSide * kSide), kUnknown);
        for (int z = m_first; z < m_last; ++z)
            for (const auto& [from, to] :
                 {std::pair{m_first, 0}, {0, grid::kPatchSize}, {grid::kPatchSize, m_last}})
                copy_known(&window.patch_at(from, z).ground_height[static_cast<std::size_t>(
                               (z & 63) * grid::kPatchSize + (from & 63))],
                           to - from, &at(from, z));
    }
    static void copy_known(const float* from, int count, float* to) noexcept {
        for (int i = 0; i < count; ++i)
            to[i] = from[i] == from[i] ? from[i] : kUnknown;
    }

    // Water, and the voids between its few returns.
    void add_water(const Rows& occupied, const Rows& wet) {
        constexpr int kScattered = 3;
        for (std::size_t i = 0; i < wet.size(); ++i) {
            if (!any(wet[i]))
                continue;
            Bits around = wet[i];
            for (int d = 1; d <= kScattered; ++d)
                around = around | east(wet[i], d) | west(wet[i], d);
            const std::size_t to = std::min(i + kScattered + 1, m_low.size());
            for (std::size_t k = i - std::min<std::size_t>(i, kScattered); k < to; ++k)
                m_low[k] = m_low[k] | (around & ~occupied[k]);
            m_low[i] = m_low[i] | wet[i];
        }
    }

    // Collects, of the columns from m_first on, those whose bit is set.
    template <class Value>
    void set(const Bits& bits, Value* values, Value value) const {
        for (std::size_t w = 0; w < 3; ++w)
            for (std::uint64_t left = bits[w]; left != 0; left &= left - 1) {
                const int i =
                    static_cast<int>(w) * 64 + std::countr_zero(left) - grid::kPatchSize - m_first;
                if (i >= 0 && i < count())
                    values[i] = value;
            }
    }

    // Which columns of a row fall by `m_drop` within three steps, to either side.
    void find_falls(const float* row, std::ptrdiff_t step, Flags& before,
                    Flags& behind) const noexcept {
        static_assert(kFall == 3);
        const int from = kFall;
        const int to = count() - kFall;
        const auto falls = [&](std::ptrdiff_t way, Flags& out) {
            std::array<float, kSide> low;
            for (int i = from; i < to; ++i)
                low[static_cast<std::size_t>(i)] =
                    lower(row[i + way], lower(row[i + 2 * way], row[i + 3 * way]));
            for (int i = from; i < to; ++i) {
                const bool fall = row[i] - low[static_cast<std::size_t>(i)] >= m_drop;
                const bool known = row[i] < kUnknown;
                out[static_cast<std::size_t>(i)] =
                    static_cast<std::uint8_t>(fall) & static_cast<std::uint8_t>(known);
            }
        };
        falls(-step, before);
        falls(step, behind);
    }
    [[nodiscard]] static float lower(float a, float b) noexcept { return a < b ? a : b; }

    [[nodiscard]] static bool none(const std::uint8_t* flags) noexcept {
        std::uint8_t sum = 0;
        for (int i = 0; i < kSide; ++i)
            sum = static_cast<std::uint8_t>(sum | flags[i]);
        return sum == 0;
    }
    [[nodiscard]] static bool none(const Flags& flags) noexcept { return none(flags.data()); }

    // @param drops receives the places of the drops
    // @return whether there is any
    bool along_rows(Marks& drops) {
        bool any_drop = false;
        for (int z = m_first; z < m_last; ++z) {
            Flags before{};
            Flags behind{};
            const float* row = &at(m_first, z);
            find_falls(row, 1, before, behind);
            const Bits &low = m_low[static_cast<std::size_t>(z + grid::kPatchSize)],
                       &thing = m_thing[static_cast<std::size_t>(z + grid::kPatchSize)];
            if (any(low) && any(thing)) {
                set(thing & (east(low, 1) | east(low, 2) | east(low, 3)), before.data(),
                    std::uint8_t{1});
                set(thing & (west(low, 1) | west(low, 2) | west(low, 3)), behind.data(),
                    std::uint8_t{1});
            }
            const bool no_before = none(before);
            const bool no_behind = none(behind);
            if (no_before && no_behind)
                continue;
            any_drop = true;
            add(before, behind, &drops[static_cast<std::size_t>((z - m_first) * kSide)]);
            if (no_before || no_behind)
                continue;
            Pairs pairs(m_chord);
            for (int i = kFall; i < count() - kFall; ++i) {
                if (before[static_cast<std::size_t>(i)] != 0)
                    pairs.open(i);
                if (behind[static_cast<std::size_t>(i)] == 0)
                    continue;
                for (int k = pairs.first(i); k <= i; ++k)
                    mark(m_first + k, z);
            }
        }
        return any_drop;
    }

    // Along lines from north to south that move by `step` columns with each row.
    // @param among null, or only columns that drop in those
    bool along_lines(int step, int chord, const Marks* among, Marks& drops) {
        bool any_drop = false;
        std::vector<Pairs> pairs(static_cast<std::size_t>(3 * kSide), Pairs(chord));
        for (int z = m_first + kFall; z < m_last - kFall; ++z) {
            const auto at_row = static_cast<std::size_t>((z - m_first) * kSide);
            if (among != nullptr && none(&(*among)[at_row]))
                continue;
            Flags before{};
            Flags behind{};
            const float* row = &at(m_first, z);
            find_falls(row, kSide + step, before, behind);
            const auto i = static_cast<std::size_t>(z + grid::kPatchSize);
            if (any(m_thing[i])) {
                const auto shifted = [&](int rows) {
                    const Bits& low = m_low[static_cast<std::size_t>(z + grid::kPatchSize + rows)];
                    const int by = rows * step;  // the bit that lies there, brought here
                    return by == 0 ? low : by > 0 ? west(low, by) : east(low, -by);
                };
                set(m_thing[i] & (shifted(-1) | shifted(-2) | shifted(-3)), before.data(),
                    std::uint8_t{1});
                set(m_thing[i] & (shifted(1) | shifted(2) | shifted(3)), behind.data(),
                    std::uint8_t{1});
            }
            if (among != nullptr)
                for (std::size_t k = 0; k < before.size(); ++k) {
                    before[k] &= (*among)[at_row + k];
                    behind[k] &= (*among)[at_row + k];
                }
            if (none(before) && none(behind))
                continue;
            any_drop = true;
            if (among == nullptr)
                add(before, behind, &drops[at_row]);
            for (int k = kFall; k < count() - kFall; ++k) {
                Pairs& line = pairs[static_cast<std::size_t>(k - step * (z - m_first) + kSide)];
                if (before[static_cast<std::size_t>(k)] != 0)
                    line.open(z);
                if (behind[static_cast<std::size_t>(k)] == 0)
                    continue;
                for (int at_z = line.first(z); at_z <= z; ++at_z)
                    mark(m_first + k + step * (at_z - z), at_z);
            }
        }
        return any_drop;
    }

    static void add(const Flags& a, const Flags& b, std::uint8_t* to) noexcept {
        for (std::size_t i = 0; i < a.size(); ++i)
            to[i] = static_cast<std::uint8_t>(to[i] | a[i] | b[i]);
    }

    // Of drops towards the beginning of a line, the first of the latest few consecutive ones.
    class Pairs {
    public:
        explicit Pairs(int chord) : m_chord(chord) {}
        void open(int i) noexcept {
            if (i - m_latest > kFall)
                m_begin = i;
            m_latest = i;
        }
        /// @return where the deck that ends here begins; past `i` when there is none
        [[nodiscard]] int first(int i) const noexcept {
            return i - m_begin <= m_chord ? m_begin : i - m_latest <= m_chord ? m_latest : i + 1;
        }

    private:
        int m_chord;
        int m_begin = -10'000;
        int m_latest = -10'000;
    };

    void mark(int x, int z) {
        if (x < DeckSeeds::kFirst || x >= DeckSeeds::kLast || z < DeckSeeds::kFirst ||
            z >= DeckSeeds::kLast)
            return;
        m_seeds.at(x, z) = 1;
        m_any = true;
    }

    float m_drop;
    int m_chord;
    int m_diagonal;
    int m_first;
    int m_last;
    std::vector<float> m_heights;
    Rows m_low{};
    Rows m_thing{};
    DeckSeeds m_seeds;
    bool m_any = false;
};

}  // namespace

std::optional<DeckSeeds> find_deck_seeds(const Window& window, const DeckLimits& limits) {
    return SeedFinder(window, limits).find();
}

}  // namespace terravox::voxelize
