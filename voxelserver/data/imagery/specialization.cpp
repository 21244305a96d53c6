#include "voxelserver/data/imagery/specialization.hpp"

#include <algorithm>

#include "common/util/error.hpp"

namespace terravox::imagery {

using voxel::Material;
using voxel::Rgb8;

namespace {

/// A class that says only "ground" or "roof" leaves the material open; any other class is definite.
bool is_open(Group group, Material own) noexcept {
    switch (group) {
        case Group::kGround:
        case Group::kDryGround: return own == Material::kGround;
        case Group::kBuilding: return own == Material::kRoof;
        case Group::kNone:
        case Group::kVegetation:
        case Group::kWater: return false;
    }
    return false;
}

void check(const SurfaceColumns& c, const Raster& raster) {
    const auto count = static_cast<std::size_t>(std::max(c.width, 0)) *
                       static_cast<std::size_t>(std::max(c.height, 0));
    const auto fits = [&](std::size_t size) { return size == count; };
    const bool points = c.point_colour.empty()
                            ? c.has_point_colour.empty()
                            : fits(c.point_colour.size()) && fits(c.has_point_colour.size());
    const bool image = raster.empty() || (raster.width == c.width && raster.height == c.height);
    if (!fits(c.group.size()) || !fits(c.material.size()) ||
        !(c.covered.empty() || fits(c.covered.size())) || !points || !image)
        throw util::Error("specialize surfaces: lists and image do not have the {} x {} columns",
                          c.width, c.height);
}

}  // namespace

Grid specialize(const SurfaceColumns& columns, const Raster& raster, const ColourMap& map) {
    check(columns, raster);
    const std::size_t count = columns.material.size();
    Grid out{columns.width,
             columns.height,
             columns.margin,
             {columns.material.begin(), columns.material.end()},
             std::vector<std::uint8_t>(count, Grid::kFixed)};
    for (std::size_t i = 0; i < count; ++i) {
        const Group group = columns.group[i];
        if (!is_open(group, columns.material[i]) || map.candidates(group) == 0)
            continue;
        out.flags[i] = Grid::kSilent;
        if (!columns.covered.empty() && columns.covered[i] != 0)
            continue;
        const std::uint8_t flags = raster.empty() ? 0 : raster.flags[i];
        const float index =
            (flags & Raster::kNir) != 0 ? ndvi(raster.nir[i], raster.red[i]) : kNoNdvi;
        Material found = Material::kAir;
        if ((flags & Raster::kColour) != 0)
            found = map.nearest(raster.colour[i], group, index);
        else if (!columns.point_colour.empty() && columns.has_point_colour[i] != 0)
            found = map.nearest(columns.point_colour[i], group, index);
        else if ((flags & Raster::kNir) != 0)
            found = map.by_ndvi(group, index);
        if (found == Material::kAir)
            continue;
        out.material[i] = found;
        out.flags[i] = 0;
    }
    return out;
}

std::vector<std::uint8_t> looks_wet(std::span<const Material> material,
                                    std::span<const std::uint8_t> reported, int width, int height,
                                    int cell, double share, double min_valid) {
    const auto count = static_cast<std::size_t>(std::max(width, 0)) *
                       static_cast<std::size_t>(std::max(height, 0));
    if (material.size() != count || (!reported.empty() && reported.size() != count))
        throw util::Error("find wet cells: lists do not have the {} x {} columns", width, height);
    if (cell < 1 || cell > 4096)
        throw util::Error("find wet cells: cells of {} columns; allowed: 1 to 4096", cell);
    const int across = (width + cell - 1) / cell;
    const int down = (height + cell - 1) / cell;
    std::vector<std::uint8_t> out;
    for (int cz = 0; cz < down; ++cz)
        for (int cx = 0; cx < across; ++cx) {
            int all = 0;
            int tell = 0;
            int wet = 0;
            for (int z = cz * cell; z < std::min((cz + 1) * cell, height); ++z)
                for (int x = cx * cell; x < std::min((cx + 1) * cell, width); ++x) {
                    const auto i = static_cast<std::size_t>(z) * static_cast<std::size_t>(width) +
                                   static_cast<std::size_t>(x);
                    const bool tells =
                        material[i] != Material::kAir && (reported.empty() || reported[i] != 0);
                    ++all;
                    tell += tells;
                    wet += tells && material[i] == Material::kWater;
                }
            out.push_back(tell > 0 && tell >= min_valid * all && wet >= share * tell ? 1 : 0);
        }
    return out;
}

}  // namespace terravox::imagery
