#include "voxelserver/make/voxelize/steps/house_returns.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace terravox::voxelize {
namespace {

constexpr double kReach_m = 1;    // of balconies and scatter before a wall
constexpr int kRoofsToClose = 5;  // of eight: a gap between points, as building fill closes it

int find_reach(double voxel_m, int most) {
    constexpr double kCoarse_m = 1.5;
    if (voxel_m > kCoarse_m)
        return 0;
    return std::clamp(static_cast<int>(std::lround(kReach_m / voxel_m)), 1, most);
}

}  // namespace

HouseReturns::HouseReturns(const Window& window, const ClassTable& classes,
                           const GroundHeights& ground, const Settings::Vegetation& settings,
                           double voxel_m)
    : m_window(window),
      m_classes(classes),
      m_ground(ground),
      m_reach(find_reach(voxel_m, kMaxReach)),
      m_gap(static_cast<std::int32_t>(std::lround(settings.canopy_gap_m / voxel_m))),
      m_tree(static_cast<float>(settings.trunk_from_m / voxel_m)),
      m_any(window.any(&PatchColumns::any_roof) && window.any(&PatchColumns::any_objects)) {
    if (!m_any)
        return;
    Grid<std::uint8_t, kMargin> roofs_around;
    // No more of the margin than is asked for.
    const int first = -GroundHeights::kMargin - far_around();
    const int last = grid::kPatchSize - first;
    window.each_built(first - m_reach, last + m_reach, [&](int x, int z) {
        const float roof = window.column(x, z).roof.height;
        for (int nz = std::max(z - m_reach, first); nz <= std::min(z + m_reach, last - 1); ++nz)
            for (int nx = std::max(x - m_reach, first); nx <= std::min(x + m_reach, last - 1);
                 ++nx) {
                Near& near = m_near.at(nx, nz);
                if (nx == x && nz == z) {
                    near.roof = roof;
                    near.built = true;
                } else if (!(near.wall >= roof))
                    near.wall = roof;
                if (std::abs(nx - x) <= 1 && std::abs(nz - z) <= 1)
                    ++roofs_around.at(nx, nz);
            }
    });
    for (int z = first; z < last; ++z)
        for (int x = first; x < last; ++x) {
            Near& near = m_near.at(x, z);
            if (!near.built && roofs_around.at(x, z) >= kRoofsToClose)
                near.roof = near.wall;
        }
}

HouseReturns::Part HouseReturns::part(int x, int z, const ObjectVoxel& o) const {
    if (!m_any || !plant_like(o))
        return Part::kNone;
    const Near& near = m_near.at(x, z);
    const bool unclassified = m_classes.meaning[o.source_class].role == Role::kSurface;
    if (of_wall(near, o.y)) {
        if (unclassified)
            return Part::kWall;
        const float above = static_cast<float>(o.y) - m_ground.at(x, z);
        return above >= m_tree && !foliage_beside(x, z, o.y, m_reach) ? Part::kWall : Part::kNone;
    }
    const bool low = static_cast<float>(o.y - m_gap) <= near.roof;
    return unclassified && low && !foliage_beside(x, z, o.y, far_around()) ? Part::kOnRoof
                                                                           : Part::kNone;
}

std::int32_t HouseReturns::clear_of_walls(int x, int z) const noexcept {
    if (!m_any || m_near.at(x, z).wall != m_near.at(x, z).wall)
        return INT32_MIN;
    const Near& near = m_near.at(x, z);
    return static_cast<std::int32_t>(std::floor(near.wall)) + 1 + (near.built ? 0 : m_reach);
}

bool HouseReturns::plant_like(const ObjectVoxel& o) const noexcept {
    const Role role = m_classes.meaning[o.source_class].role;
    return role == Role::kVegetation || role == Role::kSurface;
}

// Before a wall, its roof's edge is blurred as well. What is over a lower roof is not.
bool HouseReturns::of_wall(const Near& near, std::int32_t y) const noexcept {
    return static_cast<float>(near.built ? y : y - m_reach) <= near.wall;
}

// Whether foliage at this height is near that no house has part in.
bool HouseReturns::foliage_beside(int x, int z, std::int32_t y, int far) const {
    for (int nz = z - far; nz <= z + far; ++nz)
        for (int nx = x - far; nx <= x + far; ++nx) {
            const Near& near = m_near.at(nx, nz);
            if (near.roof == near.roof)
                continue;
            for (const ObjectVoxel& o : m_window.objects(nx, nz))
                if (std::abs(o.y - y) <= far_around() && plant_like(o) && !of_wall(near, o.y))
                    return true;
        }
    return false;
}

}  // namespace terravox::voxelize
