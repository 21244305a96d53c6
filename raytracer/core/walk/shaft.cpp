#include "raytracer/core/walk/shaft.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace terravox::walk {
namespace {

constexpr int kMaxShaftSlabs = 4;

}  // namespace

Shaft::Shaft(core::Vec3 direction, double radius_rad) noexcept {
    const double x = std::abs(direction.x);
    const double y = std::abs(direction.y);
    const double z = std::abs(direction.z);
    m_axis = y >= x && y >= z ? 1 : x >= z ? 0 : 2;
    m_forward = direction[m_axis] > 0;
    for (int a = 0; a < 3; ++a) {
        m_slope[a] = direction[a] / direction[m_axis];
        m_low[a] = core::kFar;
        m_high[a] = -core::kFar;
    }
    // With m the major component, |slope| <= 1 and both components off by at most the radius r: by
    // (r + r |slope|) / (m - r).
    m_spread = radius_rad > 0 ? 2 * radius_rad / (std::abs(direction[m_axis]) - radius_rad) : 0;
    m_first = m_forward ? std::numeric_limits<std::int32_t>::max()
                        : std::numeric_limits<std::int32_t>::min();
}

void Shaft::add(const core::Vec3& origin, const core::RayState& ray) noexcept {
    for (int a = 0; a < 3; ++a) {
        const double crossing = origin[a] - m_slope[a] * origin[m_axis];
        m_low[a] = std::min(m_low[a], crossing);
        m_high[a] = std::max(m_high[a], crossing);
    }
    m_first = m_forward ? std::min(m_first, behind(ray)) : std::max(m_first, behind(ray));
}

// The plane from which on all lines of a shaft have left the bounds, through whichever side: the
// end of the world on the shaft's own axis may be a thousand times as far. A whole number of the
// coarsest boxes, so that thick slabs begin there.
std::int32_t ShaftMarch::find_end(const Shaft& shaft) const noexcept {
    const voxel::VoxelBounds& bounds = m_cut.entry_bounds();
    const auto i = static_cast<std::size_t>(shaft.m_axis);
    const int sign = shaft.m_forward ? 1 : -1;
    const double last = shaft.m_forward ? bounds.max[i] : -bounds.min[i];
    const double first = sign * static_cast<double>(shaft.m_first);
    double end = last;
    for (int a = 0; a < 3; ++a) {
        if (a == shaft.m_axis)
            continue;
        const double rise = sign * shaft.m_slope[a];
        const double steepness = std::abs(rise) - shaft.m_spread;
        if (!(steepness > 0))
            continue;
        const auto side = static_cast<std::size_t>(a);
        const double way =
            rise > 0 ? bounds.max[side] - shaft.m_low[a] : shaft.m_high[a] - bounds.min[side];
        const double room = 1 + shaft.m_spread * (1 - first);
        end = std::min(end, (way + room) / steepness + 1);
    }
    const double box =
        static_cast<double>(std::int64_t{1} << (LevelCut::kSideBits + m_cut.coarsest()));
    end = std::min(std::ceil(std::max(end, first) / box) * box, last);
    return sign * static_cast<std::int32_t>(end);
}

std::int32_t ShaftMarch::free_from(const Shaft& shaft, std::optional<std::int32_t> known) {
    const int axis = shaft.m_axis;
    const int u = (axis + 1) % 3;
    const int w = (axis + 2) % 3;
    const int back = shaft.m_forward ? -1 : 1;
    std::int32_t plane = known ? *known : find_end(shaft);
    const auto free_between = [&](std::int32_t from, std::int32_t to, int shift) {
        // What lies behind all origins blocks no ray.
        const std::int32_t last =
            shaft.m_forward ? std::max(to, shaft.m_first) : std::min(to, shaft.m_first);
        VoxelRange range;
        range.low[axis] = std::min(from, last);
        range.high[axis] = std::max(from, last) - 1;
        for (const int a : {u, w}) {
            const double p = shaft.m_slope[a] * from;
            const double q = shaft.m_slope[a] * last;
            const double farthest =
                std::abs(static_cast<double>(shaft.m_forward ? std::max(from, last)
                                                             : std::min(from, last)) -
                         shaft.m_first) +
                1;
            const double room = shaft.m_spread * farthest + kSlabRounding_voxel;
            range.low[a] = core::RayState::floor_to_int(shaft.m_low[a] + std::min(p, q) - room);
            range.high[a] = core::RayState::floor_to_int(shaft.m_high[a] + std::max(p, q) + room);
        }
        ++m_slabs;
        return !m_query.any_solid(range, grain_of_slab(shift));
    };
    (void)march_slabs(plane, shaft.m_first, back, m_query, kMaxShaftSlabs, free_between);
    return plane;
}

}  // namespace terravox::walk
