#include "voxelserver/voxelize/building_fill.hpp"

#include <algorithm>
#include <array>

namespace terravox::voxelize {
namespace {

constexpr std::size_t kRoofsAround = 5;           // of eight: a gap between points
constexpr std::size_t kRoofsAroundCourtyard = 7;  // of eight, when the ground itself was seen through the gap
constexpr int kOpenAround = 4;            // of eight: as open as its neighbours

class BuildingFiller {
public:
    BuildingFiller(const Window& window, const Settings::Buildings& settings, double voxel_m)
        : m_window(window), m_storey_voxels(static_cast<float>(settings.storey_m / voxel_m)) {
        Built::each([&](int x, int z) {
            if (!window.built(x, z)) return;
            const Column& c = window.column(x, z);
            m_built.at(x, z) = 1;
            m_seen_below.at(x, z) = c.ground.seen() && c.roof_low - c.ground.height > m_storey_voxels ? 1 : 0;
        });
    }

    Roof at(int x, int z) const {
        Roof out;
        if (m_built.at(x, z) != 0) {
            out.top = m_window.column(x, z).roof;
            if (open(x, z)) out.bottom = m_window.column(x, z).roof_low;
            return out;
        }
        struct Near {
            const Surface* roof;
            std::int8_t dx, dz;
        };
        std::array<Near, 8> around{};
        std::size_t count = 0;
        for (int dz = -1; dz <= 1; ++dz)
            for (int dx = -1; dx <= 1; ++dx)
                if (m_built.at(x + dx, z + dz) != 0) around[count++] = {&m_window.column(x + dx, z + dz).roof, static_cast<std::int8_t>(dx), static_cast<std::int8_t>(dz)};
        if (count < kRoofsAround) return out;
        const Column& own = m_window.column(x, z);
        const bool looked_through = own.ground.seen() || own.water.seen();
        if (looked_through && count < kRoofsAroundCourtyard) return out;
        const auto middle = around.begin() + static_cast<std::ptrdiff_t>(count / 2);
        std::nth_element(around.begin(), middle, around.begin() + static_cast<std::ptrdiff_t>(count),
                         [](const Near& a, const Near& b) { return a.roof->height < b.roof->height; });
        out.top = *middle->roof;
        out.look_dx = middle->dx, out.look_dz = middle->dz;
        if (open(x, z)) out.bottom = out.top.height;
        return out;
    }

private:
    using Built = Grid<char, 5>;

    // Some square of 2 x 2 columns around (x, z) was looked beneath everywhere: no straight edge of a roof cuts through four such columns.
    [[nodiscard]] bool in_open_square(int x, int z) const {
        for (int cz = z - 1; cz <= z; ++cz)
            for (int cx = x - 1; cx <= x; ++cx)
                if (m_seen_below.at(cx, cz) + m_seen_below.at(cx + 1, cz) + m_seen_below.at(cx, cz + 1) + m_seen_below.at(cx + 1, cz + 1) == 4) return true;
        return false;
    }

    [[nodiscard]] bool open(int x, int z) const {
        if (m_seen_below.at(x, z) != 0) return in_open_square(x, z);
        // Few pulses reach far under a roof: a column between open ones is open too, unless a wall was seen in it.
        const Column& own = m_window.column(x, z);
        if (own.ground.seen()) return false;
        float ground = 0;
        int count = 0;
        for (int dz = -1; dz <= 1; ++dz)
            for (int dx = -1; dx <= 1; ++dx)
                if (m_seen_below.at(x + dx, z + dz) != 0 && in_open_square(x + dx, z + dz)) ground += m_window.column(x + dx, z + dz).ground.height, ++count;
        if (count < kOpenAround) return false;
        return !own.roof.seen() || own.roof_low - ground / static_cast<float>(count) > m_storey_voxels;
    }

    const Window& m_window;
    float m_storey_voxels;
    Built m_built, m_seen_below;
};

}  // namespace

Margined<Roof> fill_buildings(const Window& window, const Settings::Buildings& settings, double voxel_m) {
    Margined<Roof> out;
    if (!window.any(&PatchColumns::any_roof)) return out;
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
