#include "voxelserver/make/voxelize/steps/building_fill.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace terravox::voxelize {
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
