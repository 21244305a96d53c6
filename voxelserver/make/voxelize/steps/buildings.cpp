#include "voxelserver/make/voxelize/steps/buildings.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <utility>

namespace terravox::voxelize {
namespace {

constexpr int kWindowFirst = -Window::kMargin;
constexpr int kWindowLast = grid::kPatchSize + Window::kMargin;
constexpr int kWindowSide = kWindowLast - kWindowFirst;
constexpr int kNearFirst = -Buildings::kAround;
constexpr int kNearLast = grid::kPatchSize + Buildings::kAround;
// A building that is cut by the window's edge is seen wider than kWidest: all patches reject it.
static_assert(Window::kMargin - Buildings::kAround > Buildings::kWidest);
// Each begins in a column of its own, so an index has 16 bits.
static_assert((kNearLast - kNearFirst) * (kNearLast - kNearFirst) <= INT16_MAX);

constexpr std::size_t compute_index(int x, int z) noexcept {
    return static_cast<std::size_t>((z - kWindowFirst) * kWindowSide + x - kWindowFirst);
}

struct ColumnStep {
    int x;
    int z;
};
// Neighbours lie up to two columns away: where pulses are few, single columns of a roof have none.
constexpr int kFarthest = 2;
/// Those of the rows from kFarthest before the column's own on, as bits of Search::new_around.
constexpr unsigned kNeighbours[] = {0b00100, 0b01110, 0b11011, 0b01110, 0b00100};

/// The columns of one building, found from one of them.
class Search {
public:
    Search(const Window& window, double voxel_m)
        : m_window(window), m_steepest(kSteepest), m_step(kStep_m / voxel_m) {
        for (int z = kWindowFirst; z < kWindowLast; ++z)
            for (int x = kWindowFirst; x < kWindowLast; x += grid::kPatchSize)
                m_new[to_word(x, z)] =
                    window.patch_at(x, z).built[static_cast<std::size_t>(z & 63)];
    }

    [[nodiscard]] bool is_new(int x, int z) const noexcept {
        return (m_new[to_word(x, z)] >> (x & 63) & 1) != 0;
    }

    /// @return the columns that are connected with this one, as far as the window shows
    const std::vector<ColumnStep>& from(int x, int z) {
        m_columns.clear();
        add(x, z);
        for (std::size_t i = 0; i < m_columns.size(); ++i) {
            const ColumnStep at = m_columns[i];
            for (int dz = -kFarthest; dz <= kFarthest; ++dz)
                for (unsigned left = new_around(at.x, at.z + dz) & kNeighbours[dz + kFarthest];
                     left != 0; left &= left - 1)
                    visit(at, {std::countr_zero(left) - kFarthest, dz});
        }
        return m_columns;
    }

private:
    // The slope of a steep roof, and what roofs of one building differ by at most where they touch.
    static constexpr float kSteepest = 1.75F;
    static constexpr double kStep_m = 0.5;

    void visit(const ColumnStep& at, const ColumnStep& step) {
        const int x = at.x + step.x;
        const int z = at.z + step.z;
        const float rise =
            std::abs(m_window.column(x, z).roof.height - m_window.column(at.x, at.z).roof.height);
        const auto run = static_cast<float>(std::max(std::abs(step.x), std::abs(step.z)));
        if (rise > m_steepest * run + static_cast<float>(m_step))
            return;
        add(x, z);
    }

    void add(int x, int z) {
        m_new[to_word(x, z)] &= ~(std::uint64_t{1} << (x & 63));
        m_columns.push_back({x, z});
    }

    // The columns from x - kFarthest to x + kFarthest that are new, from bit 0 on.
    [[nodiscard]] unsigned new_around(int x, int z) const noexcept {
        const std::uint64_t* words = &m_new[to_word(x - kFarthest, z)];
        const int shift = (x - kFarthest) & 63;
        constexpr int kCount = 2 * kFarthest + 1;
        const std::uint64_t next = shift > 64 - kCount ? words[1] << (64 - shift) : 0;
        return static_cast<unsigned>(words[0] >> shift | next) & ((1u << kCount) - 1);
    }

    // Around the window is room for the farthest neighbours, where nothing is built.
    static constexpr int kRoom = kFarthest;
    static constexpr int kWords = kWindowSide / grid::kPatchSize + 2;
    static std::size_t to_word(int x, int z) noexcept {
        return static_cast<std::size_t>((z - kWindowFirst + kRoom) * kWords + 1 +
                                        ((x - kWindowFirst) >> 6));
    }

    const Window& m_window;
    float m_steepest;
    double m_step;
    /// Columns that are built upon and not yet found, a bit each: row by row, with a word of room
    /// at both ends.
    std::array<std::uint64_t, static_cast<std::size_t>((kWindowSide + 2 * kRoom) * kWords)> m_new{};
    std::vector<ColumnStep> m_columns;
};

}  // namespace

Buildings::Buildings(const Window& window, double voxel_m) {
    if (!window.any(&PatchColumns::any_roof))
        return;
    m_index.assign(static_cast<std::size_t>(kWindowSide) * kWindowSide, -1);
    Search search(window, voxel_m);
    window.each_built(kNearFirst, kNearLast, [&](int x, int z) {
        if (!search.is_new(x, z))
            return;
        const auto& columns = search.from(x, z);
        ColumnStep low = columns.front();
        ColumnStep high = columns.front();
        ColumnStep first = columns.front();
        for (const ColumnStep& c : columns) {
            low = {std::min(low.x, c.x), std::min(low.z, c.z)};
            high = {std::max(high.x, c.x), std::max(high.z, c.z)};
            if (c.z < first.z || (c.z == first.z && c.x < first.x))
                first = c;
        }
        if (high.x - low.x >= kWidest || high.z - low.z >= kWidest)
            return;
        const auto number = static_cast<std::int16_t>(m_buildings.size());
        m_buildings.push_back({window.middle.x0() + first.x, window.middle.z0() + first.z,
                               static_cast<std::uint32_t>(columns.size())});
        for (const ColumnStep& c : columns)
            m_index[compute_index(c.x, c.z)] = number;
    });
}

const Building* Buildings::at(int x, int z) const noexcept {
    if (m_index.empty())
        return nullptr;
    const int number = m_index[compute_index(x, z)];
    return number < 0 ? nullptr : &m_buildings[static_cast<std::size_t>(number)];
}

namespace {

constexpr std::size_t kRoofsAround = 5;  // of eight: a gap between points
// Of eight, when the ground itself was seen through the gap.
constexpr std::size_t kRoofsAroundCourtyard = 7;
constexpr int kFarBeneath = 3;         // columns: from one open place to the next, or to a wall
constexpr float kHigherWall_m = 1.5f;  // of the house that a balcony hangs on
// A higher roof with nothing seen below it is that of a house over a passage.
constexpr float kTallStoreys = 2.5f;

class BuildingFiller {
public:
    BuildingFiller(const Window& window, const Settings::Buildings& settings, double voxel_m)
        : m_window(window),
          m_storey(static_cast<float>(settings.storey_m / voxel_m)),
          m_higher(kHigherWall_m / static_cast<float>(voxel_m)) {
        Built::each([&](int x, int z) {
            if (!window.built(x, z))
                return;
            const Column& c = window.column(x, z);
            m_built.at(x, z) = 1;
            m_seen_below.at(x, z) =
                c.roof_over_ground && c.roof_low - c.ground.height > m_storey ? 1 : 0;
            m_any_below = m_any_below || m_seen_below.at(x, z) != 0;
        });
    }

    Roof at(int x, int z) const {
        Roof out;
        if (m_built.at(x, z) != 0) {
            out.top = m_window.column(x, z).roof;
            out.bottom = underside(x, z, m_window.column(x, z).roof_low);
            return out;
        }
        struct Near {
            const Surface* roof;
            std::int8_t dx;
            std::int8_t dz;
        };
        std::array<Near, 8> around{};
        std::size_t count = 0;
        for (int dz = -1; dz <= 1; ++dz)
            for (int dx = -1; dx <= 1; ++dx)
                if (m_built.at(x + dx, z + dz) != 0)
                    around[count++] = {&m_window.column(x + dx, z + dz).roof,
                                       static_cast<std::int8_t>(dx), static_cast<std::int8_t>(dz)};
        if (count < kRoofsAround)
            return out;
        const Column& own = m_window.column(x, z);
        const bool looked_through = own.ground.seen() || own.water.seen();
        if (looked_through && count < kRoofsAroundCourtyard)
            return out;
        const auto middle = around.begin() + static_cast<std::ptrdiff_t>(count / 2);
        std::nth_element(
            around.begin(), middle, around.begin() + static_cast<std::ptrdiff_t>(count),
            [](const Near& a, const Near& b) { return a.roof->height < b.roof->height; });
        out.top = *middle->roof;
        out.appearance_dx = middle->dx;
        out.appearance_dz = middle->dz;
        out.bottom = underside(x, z, out.top.height);
        return out;
    }

private:
    using Built = Grid<char, Margined<Roof>::kMargin + kFarBeneath + 1>;

    /// @param low lowest height that was seen of the roof
    /// @return where it ends below; NaN = at the ground
    [[nodiscard]] float underside(int x, int z, float low) const {
        if (!m_any_below)
            return kNoHeight;
        const float ground =
            m_seen_below.at(x, z) != 0 ? m_window.column(x, z).ground.height : ground_beneath(x, z);
        if (ground != ground || low - ground <= m_storey)
            return kNoHeight;  // NaN: there is no evidence that it is open
        return low - ground > kTallStoreys * m_storey ? ground + m_storey : low;
    }

    /// What lies in one direction from a column, under or next to its roof.
    struct Side {
        float ground = kNoHeight;  ///< of an open place
        bool wall = false;         ///< of a much higher building
    };
    [[nodiscard]] Side side(int x, int z, int dx, int dz, float top) const {
        for (int step = 1; step <= kFarBeneath; ++step) {
            const int sx = x + dx * step;
            const int sz = z + dz * step;
            if (m_built.at(sx, sz) == 0)
                return {};
            if (m_seen_below.at(sx, sz) != 0)
                return {m_window.column(sx, sz).ground.height, false};
            if (m_window.column(sx, sz).roof.height > top + m_higher)
                return {kNoHeight, true};
        }
        return {};
    }

    // The ground under a place that no pulse reached, when it lies between open places, or an open
    // place and a wall.
    [[nodiscard]] float ground_beneath(int x, int z) const {
        const Column& own = m_window.column(x, z);
        if (!own.roof.seen())
            return kNoHeight;
        for (const auto& [dx, dz] : {std::pair{1, 0}, {0, 1}, {1, 1}, {1, -1}}) {
            const Side a = side(x, z, dx, dz, own.roof.height);
            const Side b = side(x, z, -dx, -dz, own.roof.height);
            const bool open_a = a.ground == a.ground;
            const bool open_b = b.ground == b.ground;
            if (open_a && open_b)
                return (a.ground + b.ground) / 2;
            if (open_a && b.wall)
                return a.ground;
            if (open_b && a.wall)
                return b.ground;
        }
        return kNoHeight;
    }

    const Window& m_window;
    float m_storey, m_higher;  // voxels
    bool m_any_below = false;
    Built m_built;
    Built m_seen_below;
};

}  // namespace

Margined<Roof> fill_buildings(const Window& window, const Settings::Buildings& settings,
                              double voxel_m) {
    Margined<Roof> out;
    if (!window.any(&PatchColumns::any_roof))
        return out;
    const BuildingFiller filler(window, settings, voxel_m);
    Margined<Roof>::each([&](int x, int z) { out.at(x, z) = filler.at(x, z); });
    return out;
}

Margined<Roof> seen_roofs(const Window& window) {
    Margined<Roof> out;
    Margined<Roof>::each([&](int x, int z) { out.at(x, z).top = window.column(x, z).roof; });
    return out;
}

}  // namespace terravox::voxelize
