#include "voxelserver/make/worlds/heightmap/heightmap_columns.hpp"

#include <algorithm>
#include <cmath>

namespace terravox::heightmap {

using voxel::Material;
using voxel::VoxelAttr;

namespace {

// Slope from a middle and its neighbours on one axis, some of which may be missing.
double slope_of(double before, double here, double after) noexcept {
    if (!std::isnan(before) && !std::isnan(after))
        return (after - before) / 2;
    if (!std::isnan(after))
        return after - here;
    return std::isnan(before) ? 0 : here - before;
}

}  // namespace

HeightmapColumns::HeightmapColumns(int level, const ColumnHeights& heights,
                                   const imagery::Raster& colours)
    : m_tops(kSide * kSide, kNothing),
      m_appearances(static_cast<std::size_t>(voxel::kBoxSizeX) * voxel::kBoxSizeZ) {
    // The voxel that holds the height is solid, so columns of level 0 end half a voxel above it on
    // average; coarser ones end where those do, rounded. A mean of equal numbers may be one bit too
    // small: heights that miss a voxel by less than a millionth are counted as in it.
    constexpr double kNudge = 1e-6;
    const double up = std::ldexp(0.5, -level) + 0.5 + kNudge;
    for (int z = -1; z <= voxel::kBoxSizeZ; ++z)
        for (int x = -1; x <= voxel::kBoxSizeX; ++x) {
            const auto height = [&](int dx, int dz) {
                return heights.at(heights.x + x + 1 + dx, heights.z + z + 1 + dz);
            };
            const double here = height(0, 0);
            if (std::isnan(here))
                continue;
            const auto top = static_cast<std::int32_t>(std::floor(here + up));
            m_tops[static_cast<std::size_t>((z + 1) * kSide + x + 1)] = top;
            m_highest = std::max(m_highest, top);
            m_lowest = std::min(m_lowest, top);
            if (x < 0 || z < 0 || x >= voxel::kBoxSizeX || z >= voxel::kBoxSizeZ)
                continue;
            const auto at = static_cast<std::size_t>(z * voxel::kBoxSizeX + x);
            const double dx = slope_of(height(-1, 0), here, height(1, 0));
            const double dz = slope_of(height(0, -1), here, height(0, 1));
            m_appearances[at] = appearance(std::sqrt(dx * dx + dz * dz), colours, at);
        }
}

VoxelAttr HeightmapColumns::appearance(double slope, const imagery::Raster& colours,
                                       std::size_t at) noexcept {
    constexpr double kBare = 0.75,
                     kRock = 1.1;  // 37 and 48 degrees: soil slides, then nothing holds
    VoxelAttr out;
    out.material = slope > kRock   ? Material::kRock
                   : slope > kBare ? Material::kGround
                                   : Material::kGrass;
    if (colours.empty() || (colours.flags[at] & imagery::Raster::kColour) == 0)
        return out;
    out.colour = colours.colour[at];
    out.flags = VoxelAttr::kHasColour;
    // A green colour means grass; any other may be anything.
    const voxel::Rgb8 c = out.colour;
    if (out.material == Material::kGrass && !(c.g >= c.r && c.g > c.b))
        out.material = Material::kGround;
    return out;
}

VoxelAttr HeightmapColumns::attr(int x, int z, std::int32_t depth) const noexcept {
    // Voxels of soil below grass; in the photo's colour, because a photo shows the slope as soil.
    constexpr std::int32_t kTurf = 3;
    VoxelAttr out = m_appearances[static_cast<std::size_t>(z * voxel::kBoxSizeX + x)];
    if (depth == 0)
        return out;
    if (depth > kTurf || out.material == Material::kRock) {
        if (depth > kTurf) {
            out.flags = 0;
            out.colour = {};
        }
        out.material = Material::kRock;
    } else if (out.material == Material::kGrass) {
        out.material = out.has_colour() ? Material::kGround : Material::kSoil;
    }
    return out;
}

}  // namespace terravox::heightmap
