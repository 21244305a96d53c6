#include "raytracer/walk/shaft.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace terravox {
namespace {

constexpr double kRounding_voxel = 1e-3;
constexpr int kMostFineSlabs = 4;
constexpr int kMostShift = 30;

}  // namespace

Shaft::Shaft(Vec3 direction) noexcept {
    const double x = std::abs(direction.x), y = std::abs(direction.y), z = std::abs(direction.z);
    m_axis = y >= x && y >= z ? 1 : x >= z ? 0 : 2;
    m_forward = direction[m_axis] > 0;
    for (int a = 0; a < 3; ++a) m_slope[a] = direction[a] / direction[m_axis], m_low[a] = kFar, m_high[a] = -kFar;
    m_first = m_forward ? std::numeric_limits<std::int32_t>::max() : std::numeric_limits<std::int32_t>::min();
}

void Shaft::add(const Vec3& origin, const RayState& ray) noexcept {
    for (int a = 0; a < 3; ++a) {
        const double crossing = origin[a] - m_slope[a] * origin[m_axis];
        m_low[a] = std::min(m_low[a], crossing), m_high[a] = std::max(m_high[a], crossing);
    }
    m_first = m_forward ? std::min(m_first, behind(ray)) : std::max(m_first, behind(ray));
}

std::int32_t ShaftMarch::free_from(const Shaft& shaft, std::optional<std::int32_t> known) {
    const int axis = shaft.m_axis, u = (axis + 1) % 3, w = (axis + 2) % 3;
    const voxel::VoxelBounds& bounds = m_cut.entry_bounds();
    const auto i = static_cast<std::size_t>(axis);
    const int back = shaft.m_forward ? -1 : 1;
    std::int32_t plane = known ? *known : shaft.m_forward ? bounds.max[i] : bounds.min[i];
    const auto free_between = [&](std::int32_t near, std::int32_t far, int shift) {
        VoxelRange range;
        range.low[axis] = std::min(near, far), range.high[axis] = std::max(near, far) - 1;
        for (const int a : {u, w}) {
            const double p = shaft.m_slope[a] * near, q = shaft.m_slope[a] * far;
            range.low[a] = RayState::floor_to_int(shaft.m_low[a] + std::min(p, q) - kRounding_voxel);
            range.high[a] = RayState::floor_to_int(shaft.m_high[a] + std::max(p, q) + kRounding_voxel);
        }
        ++m_slabs;
        return !m_query.any_solid(range, std::max(shift - 2, 0));
    };
    int shift = kMostShift, fine = 0;
    while (shaft.m_forward ? plane > shaft.m_first : plane < shaft.m_first) {
        const int finest = m_query.level();
        shift = std::clamp(std::min({shift, finest + LevelCut::kSideBits, plane == 0 ? kMostShift : std::countr_zero(static_cast<std::uint32_t>(plane))}), 0, kMostShift);
        while (true) {
            if (shift <= finest && fine++ >= kMostFineSlabs) return plane;
            const std::int32_t next = plane + back * (std::int32_t{1} << shift);
            // What lies behind all origins is in nobody's way.
            const std::int32_t near = shaft.m_forward ? std::max(next, shaft.m_first) : std::min(next, shaft.m_first);
            if (free_between(near, plane, shift)) {
                plane = next;
                shift += 2;
                break;
            }
            if (shift <= m_query.level() || shift == 0) return plane;
            shift = std::max(shift - 2, 0);
        }
    }
    return plane;
}

}  // namespace terravox
