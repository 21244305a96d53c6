#include "voxelserver/out/export/core/part.hpp"

#include <algorithm>
#include <cmath>

#include "common/util/error.hpp"

namespace terravox::exports {
namespace {

std::int32_t voxel_at(double value, double per_voxel, bool upper) {
    constexpr double kFarthest = 1 << 30;
    const double at = value / per_voxel;
    return static_cast<std::int32_t>(
        std::clamp(upper ? std::ceil(at) : std::floor(at), -kFarthest, kFarthest));
}

}  // namespace

Part part_of(const voxel::WorldInfo& world, const Selection& s) {
    const auto refuse = [](const std::string& what) -> void {
        throw util::UsageError("choose the part: " + what);
    };
    const auto text = [](const std::vector<double>& numbers) {
        std::string out;
        for (const double n : numbers)
            out += (out.empty() ? "" : ",") + std::to_string(n);
        return out;
    };
    if (s.level < 0 || s.level >= world.levels)
        refuse("level " + std::to_string(s.level) + "; allowed: 0 to " +
               std::to_string(world.levels - 1));
    voxel::VoxelBounds b = s.area.empty() ? world.framed_bounds() : world.bounds;
    if (!s.area.empty()) {
        if (s.area[0] >= s.area[2] || s.area[1] >= s.area[3])
            refuse("--area " + text(s.area) +
                   " is empty or upside down; allowed: west,south,east,north, or x0,z0,x1,z1 in a "
                   "world without a CRS");
        const bool placed = !world.crs.empty();
        const double unit = placed ? world.crs_units_per_voxel : 1;
        b.min[0] = std::max(b.min[0], voxel_at(s.area[0], unit, false));
        b.max[0] = std::min(b.max[0], voxel_at(s.area[2], unit, true));
        // Northings grow to the north, z to the south.
        b.min[2] = std::max(b.min[2], voxel_at(placed ? -s.area[3] : s.area[1], unit, false));
        b.max[2] = std::min(b.max[2], voxel_at(placed ? -s.area[1] : s.area[3], unit, true));
    }
    if (!s.heights.empty()) {
        if (s.heights[0] >= s.heights[1])
            refuse("--heights " + text(s.heights) +
                   " is empty or upside down; allowed: lowest,highest in metres");
        b.min[1] = std::max(b.min[1], voxel_at(s.heights[0], world.voxel_m, false));
        b.max[1] = std::min(b.max[1], voxel_at(s.heights[1], world.voxel_m, true));
    }
    if (b.empty()) {
        const auto& all = world.bounds;
        const double unit = world.crs.empty() ? 1 : world.crs_units_per_voxel;
        const double south = world.crs.empty() ? all.min[2] : -all.max[2] * unit;
        const double north = world.crs.empty() ? all.max[2] : -all.min[2] * unit;
        refuse("nothing of the world lies in it; allowed: --area within " +
               text({all.min[0] * unit, south, all.max[0] * unit, north}) + ", --heights within " +
               text({all.min[1] * world.voxel_m, all.max[1] * world.voxel_m}));
    }
    Part part{s.level, b};
    for (std::size_t a = 0; a < 3; ++a) {
        part.bounds.min[a] = b.min[a] >> s.level;
        part.bounds.max[a] = (b.max[a] - 1) >> s.level;
        ++part.bounds.max[a];
    }
    // All boxes of each column of boxes are requested.
    constexpr std::int32_t kMaxHigh = 4096;
    const voxel::BoxRange boxes = part.boxes();
    if (const std::int32_t high = boxes.max.by - boxes.min.by; high > kMaxHigh)
        refuse(std::to_string(high) + " boxes of " + std::to_string(voxel::kBoxSizeY) +
               " voxels high; allowed: up to " + std::to_string(kMaxHigh) +
               ", by --heights or a coarser --level");
    return part;
}

}  // namespace terravox::exports
