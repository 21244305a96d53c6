#include "voxelserver/voxelize/box_column.hpp"

#include <algorithm>
#include <cmath>

#include "voxelserver/voxelize/bridge_fill.hpp"
#include "voxelserver/voxelize/building_fill.hpp"
#include "voxelserver/voxelize/ground_fill.hpp"
#include "voxelserver/voxelize/input_prints.hpp"
#include "voxelserver/voxelize/runs.hpp"
#include "voxelserver/voxelize/vegetation_fill.hpp"
#include "voxelserver/voxelize/water_fill.hpp"

namespace terravox::voxelize {
namespace {

constexpr std::size_t kLeastWide =
    std::size_t{1} << 20;  // without it, the surroundings of a gap would be made for every column

water::WaterOptions water_options(const Settings& settings, int cell_voxels, double voxel_m,
                                  std::size_t memory_bytes) {
    water::WaterOptions out;
    out.cell_voxels = cell_voxels, out.voxel_m = voxel_m, out.memory_bytes = memory_bytes;
    out.evidence.by_class = settings.water.from_class,
    out.evidence.by_photo = settings.water.from_orthophoto,
    out.evidence.by_void = settings.water.from_voids;
    return out;
}

}  // namespace

BoxColumnMaker::BoxColumnMaker(PointSet& points, const imagery::Orthophotos* images,
                               const Settings& settings, std::size_t memory_bytes,
                               util::StageTimes& times)
    : m_points(points),
      m_settings(settings),
      m_times(times),
      m_voxel_m(points.sources().frame.voxel_m()),
      m_surface(images, points.classes(), settings, points.sources().has_water_class, m_voxel_m,
                memory_bytes / 4, times),
      m_cells(points, m_surface, memory_bytes / 4),
      m_bodies(m_cells, water_options(settings, points.cell_voxels(), m_voxel_m, memory_bytes / 4)),
      m_wide_ground(points, std::max(memory_bytes / 4, kLeastWide)) {}

BoxColumnMaker::Land BoxColumnMaker::land_of(const Window& window) {
    Land out;
    // Every later step looks at the window only, and at what these two tell.
    WaterAccess access{m_cells, m_bodies, m_points.cell_voxels()};
    out.reach = reach_of(window.middle, 1);
    out.water = timed("water", [&] {
        return fill_water(window, m_settings.steps.water_equalization ? &access : nullptr,
                          m_settings, m_voxel_m);
    });
    if (m_settings.steps.bridges)
        out.decks = timed("bridges", [&] {
            auto found = find_decks(window, m_points.classes(),
                                    m_settings.steps.water_equalization ? &access : nullptr,
                                    m_settings.bridges, m_voxel_m);
            if (found)
                flow_beneath(*found, m_settings.water.min_depth_m, out.water);
            return found;
        });
    const auto bounds = m_points.in_bounds(window.middle);
    out.covered = timed("coverage", [&] {
        const int radius =
            std::clamp(static_cast<int>(std::lround(kWidestGap_m / m_voxel_m)), 4, 31);
        Margined<char> covered = find_coverage(window, bounds, radius);
        // A body of water belongs to the survey however little it returned.
        Margined<char>::each([&](int x, int z) {
            if (out.water.is_water(x, z) && bounds.at(x, z) != 0)
                covered.at(x, z) = 1;
        });
        return covered;
    });
    out.ground = timed("ground fill", [&] {
        if (!m_settings.steps.ground_fill)
            return seen_ground(window);
        Grid<char, GroundHeights::kMargin> wanted;
        GroundHeights::each([&](int x, int z) {
            wanted.at(x, z) = bounds.at(x, z) != 0 && !out.water.is_water(x, z) ? 1 : 0;
        });
        // A hole has no ground, and its edge needs none beyond it.
        Margined<char>::each([&](int x, int z) {
            wanted.at(x, z) = static_cast<char>(wanted.at(x, z) & out.covered.at(x, z));
        });
        return fill_ground(window, wanted, [&](std::int32_t x, std::int32_t z) {
            return m_wide_ground.at(x, z, out.reach);
        });
    });
    out.reach.add(access.reach);
    if (out.decks)
        lower_ground(*out.decks, out.ground);
    return out;
}

Margined<Crown> BoxColumnMaker::crowns_of(const Window& window, const Land& land) {
    return timed("vegetation", [&] {
        if (!m_settings.steps.vegetation_fill)
            return Margined<Crown>{};
        auto crowns = fill_crowns(window, m_points.classes(), land.ground, m_settings, m_voxel_m);
        if (land.decks)
            clear_crowns(*land.decks, m_settings.vegetation.trunk_from_m, m_voxel_m, crowns);
        return crowns;
    });
}

BoxColumn BoxColumnMaker::make(PatchKey patch) {
    const Window window = m_points.window(patch);
    const Land land = land_of(window);
    BoxColumn out;
    out.reach = land.reach;
    const auto bounds = m_points.in_bounds(patch);
    std::uint64_t holes = 0, covered = 0;
    for (int z = 0; z < kPatchSize; ++z)
        for (int x = 0; x < kPatchSize; ++x)
            (land.covered.at(x, z) != 0 ? covered : holes) += bounds.at(x, z) != 0 ? 1 : 0;
    if (holes > 0) {
        const std::lock_guard lock(m_holes_mutex);
        if (m_with_holes.insert(patch).second)
            m_hole_columns += holes;
    }
    if (covered == 0)
        return out;

    const auto roofs = timed("building fill", [&] {
        return m_settings.steps.building_fill
                   ? fill_buildings(window, m_settings.buildings, m_voxel_m)
                   : seen_roofs(window);
    });
    const auto decks = timed("bridges", [&] {
        return m_settings.steps.bridges ? fill_decks(window, land.decks.get()) : seen_decks(window);
    });
    const auto crowns = crowns_of(window, land);
    const SurfaceLook look = m_surface.look(window);
    const PatchRuns runs = timed("underground fill", [&] {
        return make_runs({window, m_points.classes(), m_settings, land.covered, land.water,
                          land.ground, roofs, decks, crowns, look.material,
                          m_points.sources().floor_y, m_voxel_m});
    });
    if (runs.min_y() >= runs.max_y())
        return out;
    const util::StageTimes::Scope scope(m_times, "serialization");
    out.by_begin = voxel::floor_div(runs.min_y(), voxel::kBoxSizeY);
    const std::int32_t end = voxel::floor_div(runs.max_y() - 1, voxel::kBoxSizeY) + 1;
    for (std::int32_t by = out.by_begin; by < end; ++by)
        out.boxes.push_back(serialize({0, patch.px, by, patch.pz}, runs, look));
    return out;
}

std::vector<Tree> BoxColumnMaker::trees(PatchKey patch) {
    const Window window = m_points.window(patch);
    const Land land = land_of(window);
    const auto crowns = crowns_of(window, land);
    std::vector<Tree> out;
    for (int z = 0; z < kPatchSize; ++z)
        for (int x = 0; x < kPatchSize; ++x)
            if (const Crown& crown = crowns.at(x, z);
                crown.seen() && crown.trunk && land.covered.at(x, z) != 0)
                out.push_back({patch.x0() + x, patch.z0() + z, crown.height, land.ground.at(x, z)});
    return out;
}

std::vector<float> BoxColumnMaker::ground_heights(PatchKey patch) {
    const Land land = land_of(m_points.window(patch));
    std::vector<float> out;
    out.reserve(kPatchColumns);
    for (int z = 0; z < kPatchSize; ++z)
        for (int x = 0; x < kPatchSize; ++x)
            out.push_back(land.covered.at(x, z) != 0 && !land.water.is_water(x, z)
                              ? land.ground.at(x, z)
                              : kNoHeight);
    return out;
}

}  // namespace terravox::voxelize
