#include "raytracer/apps/library/map_frame.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "common/util/error.hpp"

namespace terravox {
namespace {

/// Voxels [begin, end) that cover [low, high], within those of the world.
void cover(double low, double high, std::int32_t begin, std::int32_t end, std::int32_t& from,
           std::int32_t& to) {
    // Borders that are meant to be those of voxels may be off by rounding.
    constexpr double kSlack = 1e-6;
    from = static_cast<std::int32_t>(
        std::clamp(std::floor(low + kSlack), static_cast<double>(begin), static_cast<double>(end)));
    to = static_cast<std::int32_t>(
        std::clamp(std::ceil(high - kSlack), static_cast<double>(begin), static_cast<double>(end)));
}

std::string text_of(const MapBounds& b) {
    return std::to_string(b.west) + ", " + std::to_string(b.south) + ", " + std::to_string(b.east) +
           ", " + std::to_string(b.north) + ", heights " + std::to_string(b.bottom) + " to " +
           std::to_string(b.top);
}

}  // namespace

voxel::VoxelBounds MapFrame::block_over(const MapBounds& bounds, int level,
                                        const voxel::VoxelBounds& world) const {
    for (const double edge :
         {bounds.west, bounds.south, bounds.east, bounds.north, bounds.bottom, bounds.top})
        if (std::isnan(edge))
            throw util::UsageError("find voxels: an edge of the bounds is not a number (" +
                                   text_of(bounds) + "); allowed: numbers");
    const double scale = static_cast<double>(std::int64_t{1} << level);
    const std::int32_t side = std::int32_t{1} << level;
    const double low[3] = {bounds.west / m_units, bounds.bottom / m_voxel_m,
                           -bounds.north / m_units};
    const double high[3] = {bounds.east / m_units, bounds.top / m_voxel_m, -bounds.south / m_units};
    voxel::VoxelBounds out;
    for (std::size_t a = 0; a < 3; ++a) {
        const std::int32_t begin = voxel::floor_div(world.min[a], side);
        const std::int32_t end = voxel::floor_div(world.max[a] - 1, side) + 1;
        cover(low[a] / scale, high[a] / scale, begin, end, out.min[a], out.max[a]);
    }
    if (out.empty())
        throw util::UsageError("find voxels: nothing is within " + text_of(bounds) +
                               "; allowed: what overlaps " + text_of(bounds_of(world)));
    return out;
}

}  // namespace terravox
