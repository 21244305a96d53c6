#include "voxelserver/make/worlds/procedural/columns.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "common/voxel/world.hpp"
#include "voxelserver/make/worlds/procedural/noise.hpp"
#include "voxelserver/make/worlds/procedural/terrain.hpp"

namespace terravox::procedural {

namespace {

constexpr std::int32_t kLattice = 4;  // columns between nodes of slowly changing values

}  // namespace

using voxel::Material;
using voxel::VoxelAttr;

void Columns::add_run(int x, int z, std::int32_t y0, std::int32_t y1, bool trunk,
                      const VoxelAttr& attr) {
    Column& column = m_columns[index(x, z)];
    y0 = std::max(y0, std::max(column.top, column.water));
    if (y0 >= y1)
        return;
    m_runs.push_back({y0, y1, column.first_run, trunk, attr});
    column.first_run = static_cast<std::int32_t>(m_runs.size()) - 1;
    m_highest = std::max(m_highest, y1);
}

voxel::Rgb8 Columns::rock_colour(const Column& column, int x, std::int32_t y,
                                 int z) const noexcept {
    const double voxel = static_cast<double>(std::int64_t{1} << m_level);
    const double px = (m_x0 + x + 0.5) * voxel;
    const double py = (y + 0.5) * voxel;
    const double pz = (m_z0 + z + 0.5) * voxel;
    const double bend =
        3.5 * simplex(m_rock_seed, px * (1.0 / 45), py * (1.0 / 30), pz * (1.0 / 45));
    return Surface::rock_colour(static_cast<double>(column.temperature),
                                static_cast<double>(column.moisture), py + bend);
}

VoxelAttr Columns::attr(int x, std::int32_t y, int z) const noexcept {
    const Column& c = at(x, z);
    VoxelAttr out;
    out.flags = VoxelAttr::kHasColour;
    if (y < c.top) {
        const std::int32_t depth = c.top - 1 - y;
        if (depth == 0 && c.material != Material::kRock) {
            out.material = c.material;
            out.colour = c.colour;
        } else if (depth > 0 && depth <= c.under_depth && c.under != Material::kRock) {
            out.material = c.under;
            out.colour = c.under_colour;
        } else {
            out.material = Material::kRock;
            out.colour = rock_colour(c, x, y, z);
        }
        return out;
    }
    if (y < c.water) {
        const bool top = y == c.water - 1;
        if (top && c.snow) {
            out.material = Material::kSnow;
            out.colour = rgb(0xe4ecf2);
        } else {
            out.material = top && c.ice ? Material::kIce : Material::kWater;
            out.flags = 0;
        }
        return out;
    }
    const Run* found = nullptr;
    for (std::int32_t i = c.first_run; i >= 0;) {
        const Run& run = m_runs[static_cast<std::size_t>(i)];
        if (y >= run.y0 && y < run.y1 && (found == nullptr || (run.trunk && !found->trunk)))
            found = &run;
        i = run.next;
    }
    return found != nullptr ? found->attr : out;
}

/// Heights of level 0: those of the box and its slopes, and any of those that plants reaching into
/// the box stand on, which are few.
class ColumnMaker::FineHeights {
public:
    static constexpr int kReach = Columns::kMargin + kTreeReach;

    FineHeights(const Terrain& terrain, std::int32_t x0, std::int32_t z0)
        : m_terrain(terrain),
          m_x0(x0 - Columns::kMargin),
          m_z0(z0 - Columns::kMargin),
          m_regions(terrain, x0 - kReach, z0 - kReach,
                    voxel::kBoxSizeX + 2 * kReach + Surface::kSlopeRun, kLattice),
          m_heights(kSide * kSide) {
        for (int z = 0; z < kSide; ++z)
            for (int x = 0; x < kSide; ++x)
                m_heights[static_cast<std::size_t>(z * kSide + x)] = made(m_x0 + x, m_z0 + z);
    }
    [[nodiscard]] Region region_at(std::int32_t x, std::int32_t z) const noexcept {
        return m_regions.at(x, z);
    }
    [[nodiscard]] double height(std::int32_t x, std::int32_t z) const noexcept {
        const std::int32_t in_x = x - m_x0;
        const std::int32_t in_z = z - m_z0;
        const bool kept = in_x >= 0 && in_z >= 0 && in_x < kSide && in_z < kSide;
        return kept ? m_heights[static_cast<std::size_t>(in_z * kSide + in_x)] : made(x, z);
    }

private:
    static constexpr int kSide = Columns::kSide + Surface::kSlopeRun;
    [[nodiscard]] double made(std::int32_t x, std::int32_t z) const noexcept {
        return m_terrain.heights(m_regions.at(x, z), x + 0.5, z + 0.5, 1).full;
    }
    const Terrain& m_terrain;
    std::int32_t m_x0;
    std::int32_t m_z0;
    RegionLattice m_regions;
    std::vector<double> m_heights;
};

/// Slowly changing values for coarse levels: from a lattice where that is finer than they change,
/// else computed directly.
class ColumnMaker::CoarseRegions {
public:
    CoarseRegions(const Terrain& terrain, int level, std::int32_t x0, std::int32_t z0)
        : m_terrain(terrain) {
        // Fine columns about the box that are queried; a level.
        constexpr int kRoom = 12;
        constexpr int kMaxLattice = 4;
        if (level > kMaxLattice)
            return;
        const std::int32_t margin = (1 << level) + kRoom;
        m_lattice.emplace(terrain, (x0 << level) - margin, (z0 << level) - margin,
                          (voxel::kBoxSizeX << level) + 2 * margin, std::max(kLattice, 1 << level));
    }
    [[nodiscard]] Region at(std::int32_t x, std::int32_t z) const noexcept {
        return m_lattice ? m_lattice->at(x, z) : m_terrain.region(x + 0.5, z + 0.5);
    }

private:
    const Terrain& m_terrain;
    std::optional<RegionLattice> m_lattice;
};

ColumnMaker::ColumnMaker(const Settings& settings)
    : m_terrain(settings), m_surface(m_terrain), m_vegetation(m_terrain) {}

Columns ColumnMaker::empty(int level, std::int32_t bx, std::int32_t bz) const {
    Columns out;
    out.m_level = level;
    out.m_x0 = bx * voxel::kBoxSizeX;
    out.m_z0 = bz * voxel::kBoxSizeZ;
    out.m_rock_seed = make_seed(m_terrain.settings().seed, 103);
    out.m_columns.resize(Columns::kSide * Columns::kSide);
    return out;
}

Columns ColumnMaker::make(int level, std::int32_t bx, std::int32_t bz) const {
    Columns out = level == 0 ? make_fine(bx, bz) : make_coarse(level, bx, bz);
    for (const Column& c : out.m_columns)
        out.m_highest = std::max({out.m_highest, c.top, c.water});
    return out;
}

void ColumnMaker::set_ground(Column& column, const Place& place, const Skin& skin, int level,
                             double smooth_height) const noexcept {
    const double voxel = static_cast<double>(std::int64_t{1} << level);
    const auto rounded = [&](double v) {
        return static_cast<std::int32_t>(std::floor(v / voxel + 0.5));
    };
    const double sea = m_terrain.settings().water_level;
    const std::int32_t surface = rounded(sea);
    column.top = column.water = rounded(smooth_height);
    const bool wet =
        level == 0 ? column.top < surface
                   : smooth_height < sea - 0.5;  // as level 0 rounds to a height below the sea
    if (wet) {
        // Water is never lost, however shallow it is among voxels of this size, and never without a
        // bed.
        column.top = std::min(column.top, surface - 1);
        column.water = surface;
    }
    column.material = skin.material;
    column.under = skin.under;
    column.colour = skin.colour;
    column.under_colour = skin.under_colour;
    column.under_depth = static_cast<std::uint8_t>(skin.under_depth >> level);
    column.temperature = static_cast<float>(place.temperature);
    column.moisture = static_cast<float>(place.moisture);
    column.ice = wet && Surface::freezes(place);
    column.snow = column.ice && Surface::snowed_under(place);
}

Columns ColumnMaker::make_fine(std::int32_t bx, std::int32_t bz) const {
    const std::int32_t x0 = bx * voxel::kBoxSizeX;
    const std::int32_t z0 = bz * voxel::kBoxSizeZ;
    const FineHeights heights(m_terrain, x0, z0);
    Columns out = empty(0, bx, bz);
    const auto look = [&](std::int32_t x, std::int32_t z) {
        constexpr int kRun = Surface::kSlopeRun;
        return m_surface.place(heights.region_at(x, z), x, z, heights.height(x, z),
                               heights.height(x + kRun, z), heights.height(x, z + kRun));
    };
    for (int z = -1; z <= voxel::kBoxSizeZ; ++z)
        for (int x = -1; x <= voxel::kBoxSizeX; ++x) {
            const Place place = look(x0 + x, z0 + z);
            const Skin skin = m_surface.skin(place);
            Column& column = out.m_columns[Columns::index(x, z)];
            set_ground(column, place, skin, 0, place.height);
            if (const auto tuft = m_vegetation.tuft(place, skin))
                out.add_run(x, z, column.top, column.top + 1, false, *tuft);
        }
    const auto cell = [](std::int32_t column) {
        return voxel::floor_div(column, Vegetation::kCell);
    };
    constexpr int kReach = FineHeights::kReach;
    for (std::int32_t cz = cell(z0 - kReach); cz <= cell(z0 + voxel::kBoxSizeZ + kReach - 1); ++cz)
        for (std::int32_t cx = cell(x0 - kReach); cx <= cell(x0 + voxel::kBoxSizeX + kReach - 1);
             ++cx) {
            const auto spot = m_vegetation.spot(cx, cz);
            const bool near = spot.x >= x0 - kReach && spot.x < x0 + voxel::kBoxSizeX + kReach &&
                              spot.z >= z0 - kReach && spot.z < z0 + voxel::kBoxSizeZ + kReach;
            if (!near || !m_vegetation.possible(spot))
                continue;
            const Place place = look(spot.x, spot.z);
            if (const auto tree = m_vegetation.tree(spot, place, m_surface.skin(place)))
                plant(out, *tree, x0, z0);
        }
    return out;
}

void ColumnMaker::plant(Columns& out, const Tree& tree, std::int32_t x0, std::int32_t z0) const {
    const int level = out.m_level;
    const int reach = tree_reach(tree);
    const auto first = [&](std::int32_t v) {
        return (v - reach + (1 << level) - 1) >> level;
    };  // coarse columns whose key columns it reaches
    for (std::int32_t z = std::max(first(tree.z), z0 - 1);
         z <= std::min((tree.z + reach) >> level, z0 + voxel::kBoxSizeZ); ++z)
        for (std::int32_t x = std::max(first(tree.x), x0 - 1);
             x <= std::min((tree.x + reach) >> level, x0 + voxel::kBoxSizeX); ++x) {
            const TreeRuns runs = tree_runs(tree, (x << level) - tree.x, (z << level) - tree.z);
            for (int i = 0; i < runs.count; ++i) {
                const TreeRun& run = runs.runs[static_cast<std::size_t>(i)];
                out.add_run(x - x0, z - z0, (tree.base + run.y0) >> level,
                            ((tree.base + run.y1 - 1) >> level) + 1, run.trunk,
                            run.trunk ? tree.trunk : tree.leaves);
            }
        }
}

Place ColumnMaker::place_at(const CoarseRegions& regions, const Region& region, std::int32_t x,
                            std::int32_t z, double height) const noexcept {
    constexpr int kRun = Surface::kSlopeRun;
    const auto find_height = [&](std::int32_t bx, std::int32_t bz) {
        return m_terrain.heights(regions.at(bx, bz), bx + 0.5, bz + 0.5, 1).full;
    };
    // The slope of a bed makes no difference to it.
    if (height < m_terrain.settings().water_level)
        return m_surface.place(region, x, z, height, height, height);
    return m_surface.place(region, x, z, height, find_height(x + kRun, z),
                           find_height(x, z + kRun));
}

Columns ColumnMaker::make_coarse(int level, std::int32_t bx, std::int32_t bz) const {
    const std::int32_t x0 = bx * voxel::kBoxSizeX;
    const std::int32_t z0 = bz * voxel::kBoxSizeZ;
    const std::int32_t half = std::int32_t{1} << (level - 1);
    const double voxel = static_cast<double>(std::int64_t{1} << level);
    const CoarseRegions regions(m_terrain, level, x0, z0);
    Columns out = empty(level, bx, bz);
    for (int z = -1; z <= voxel::kBoxSizeZ; ++z)
        for (int x = -1; x <= voxel::kBoxSizeX; ++x) {
            // The margin of the outermost boxes lies outside the range of coordinates at the
            // coarsest levels, but fits 32 bits: 2^25 is far from 2^31.
            const std::int32_t fine_x = ((x0 + x) << level) + half;
            const std::int32_t fine_z = ((z0 + z) << level) + half;
            const Region region = regions.at(fine_x, fine_z);
            const Terrain::Heights heights =
                m_terrain.heights(region, fine_x + 0.5, fine_z + 0.5, voxel);
            const Place place = place_at(regions, region, fine_x, fine_z, heights.full);
            const Skin skin = m_surface.skin(place);
            Column& column = out.m_columns[Columns::index(x, z)];
            set_ground(column, place, skin, level, heights.smooth);
            if (level < kPlantLevels) {
                if (const auto tuft = m_vegetation.tuft(place, skin)) {
                    const auto y =
                        static_cast<std::int32_t>(std::floor((place.height + 0.5) / voxel));
                    out.add_run(x, z, y, y + 1, false, *tuft);
                }
                continue;
            }
            if (column.water > column.top)
                continue;
            if (const auto crown = m_vegetation.canopy(fine_x, fine_z, place, skin)) {
                constexpr double kMiddle = 5;  // of a crown, above the ground
                const auto y =
                    static_cast<std::int32_t>(std::floor((heights.smooth + kMiddle) / voxel));
                if (y >= column.top)
                    out.add_run(x, z, column.top, y + 1, false, *crown);
                else {
                    column.wooded = true;
                    column.material = crown->material;
                    column.colour = crown->colour;
                }
            }
        }
    if (level < kPlantLevels && m_terrain.settings().trees)
        plant_coarse(out, regions, x0, z0);
    return out;
}

void ColumnMaker::plant_coarse(Columns& out, const CoarseRegions& regions, std::int32_t x0,
                               std::int32_t z0) const {
    const int level = out.m_level;
    const auto cell = [](std::int32_t column) {
        return voxel::floor_div(column, Vegetation::kCell);
    };
    const auto begin = [&](std::int32_t v) { return ((v - 1) << level) - kTreeReach; };
    const auto end = [&](std::int32_t v) {
        return ((v + voxel::kBoxSizeX + 1) << level) + kTreeReach;
    };
    for (std::int32_t cz = cell(begin(z0)); cz <= cell(end(z0)); ++cz)
        for (std::int32_t cx = cell(begin(x0)); cx <= cell(end(x0)); ++cx) {
            const auto spot = m_vegetation.spot(cx, cz);
            const bool near =
                spot.x >= begin(x0) && spot.x < end(x0) && spot.z >= begin(z0) && spot.z < end(z0);
            if (!near || !m_vegetation.possible(spot))
                continue;
            const Region region = regions.at(spot.x, spot.z);
            const double height = m_terrain.heights(region, spot.x + 0.5, spot.z + 0.5, 1).full;
            if (height < m_terrain.settings().water_level)
                continue;
            const Place place = place_at(regions, region, spot.x, spot.z, height);
            if (const auto tree = m_vegetation.tree(spot, place, m_surface.skin(place)))
                plant(out, *tree, x0, z0);
        }
}

}  // namespace terravox::procedural
