#include <terravox/world.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "common/util/error.hpp"
#include "raytracer/analyse/evaluators/analysis.hpp"
#include "raytracer/analyse/evaluators/sight.hpp"
#include "raytracer/analyse/horizon/horizon_maker.hpp"
#include "raytracer/analyse/raster/cell_file.hpp"
#include "raytracer/analyse/raster/cell_grid.hpp"
#include "raytracer/analyse/raster/relief.hpp"
#include "raytracer/analyse/solar/place_and_clock.hpp"
#include "raytracer/analyse/solar/weather.hpp"
#include "raytracer/apps/library/guarded.hpp"
#include "raytracer/apps/library/picture.hpp"
#include "raytracer/core/shade/view.hpp"

namespace terravox {
namespace {

core::AnalysisKind find_kind(const std::string& name, const scene::Scene& scene) {
    std::string allowed;
    for (const auto& word : core::kAnalysisKinds) {
        if (analyse::find_analysis(word.value).bands.empty())
            continue;
        const bool has_period = !scene.analysis.from.empty() || !scene.analysis.to.empty();
        if (name == word.text)
            return word.value == core::AnalysisKind::kSun && has_period
                       ? core::AnalysisKind::kSunPeriod
                       : word.value;
        allowed += (allowed.empty() ? "" : ", ") + std::string(word.text);
    }
    throw util::UsageError("analyse: kind '" + name + "'; allowed: " + allowed);
}

scene::Scene analysis_scene(const AnalysisOptions& options) {
    scene::Scene out = make_scene(options.scene);
    out.analysis.kind = find_kind(options.kind, out);
    out.quality.level = options.level.value_or(0);
    // A voxel covers at most a cell.
    out.quality.detail = options.level ? 0 : 1;
    return out;
}

std::vector<analyse::Observer> list_observers(const AnalysisOptions& options,
                                              const MapFrame& frame) {
    constexpr std::size_t kMost = scene::PointList::kMaxPoints;
    if (options.observers.empty() || options.observers.size() > kMost)
        throw util::UsageError("analyse sight: " + std::to_string(options.observers.size()) +
                               " observers; allowed: 1 to " + std::to_string(kMost));
    std::vector<analyse::Observer> out;
    for (const auto& at : options.observers) {
        if (!std::isfinite(at[0]) || !std::isfinite(at[1]) || !std::isfinite(at[2]))
            throw util::UsageError("analyse sight: observer " + std::to_string(out.size() + 1) +
                                   " has an endless number; allowed: finite ones");
        const core::Vec3 place = frame.to_voxels({at[0], at[1], at[2]});
        analyse::Observer observer;
        observer.x = place.x;
        observer.z = place.z;
        observer.height_m = at[2];
        observer.text = std::to_string(out.size() + 1);
        out.push_back(observer);
    }
    return out;
}

/// All bands of a finished raster, in memory.
Raster to_raster(analyse::CellFile& cells, const analyse::CellGrid& grid, const MapFrame& frame) {
    Raster out;
    out.rows = static_cast<std::size_t>(grid.rows);
    out.columns = static_cast<std::size_t>(grid.columns);
    out.cell = grid.edge_voxels * frame.units();
    out.bounds.west = static_cast<double>(grid.west) * out.cell;
    out.bounds.north = -static_cast<double>(grid.north) * out.cell;
    out.bounds.east = out.bounds.west + grid.columns * out.cell;
    out.bounds.south = out.bounds.north - grid.rows * out.cell;
    for (const analyse::RasterBand& row : cells.bands()) {
        Raster::Band band{std::string(row.name), std::string(row.unit), {}};
        cells.read(row.name, {0, 0, grid.columns, grid.rows}, band.values);
        std::replace(band.values.begin(), band.values.end(), core::kNoData,
                     std::numeric_limits<float>::quiet_NaN());
        out.bands.push_back(std::move(band));
    }
    return out;
}

}  // namespace

Raster World::analyse(const AnalysisOptions& options, const Control& control) const {
    return guarded(control, [&] {
        const WorldCall call(*m_state, options.threads);
        const voxel::WorldInfo& world = m_state->world->info();
        if (options.level)
            m_state->check_level(*options.level);
        scene::Scene scene = analysis_scene(options);
        const core::AnalysisKind kind = scene.analysis.kind;
        const analyse::Analysis& analysis = analyse::find_analysis(kind);
        if (analysis.sun != analyse::SunUse::kNone && !world.centre)
            throw util::UsageError("analyse " + options.kind + ": '" + world.title +
                                   "' has no place on Earth; allowed: worlds with a CRS");
        const analyse::CellGrid grid =
            analyse::grid_over(world, m_state->columns_over(options.area, 0), options.resolution_m);
        analyse::look_at_cells(grid, world, scene);
        if (kind == core::AnalysisKind::kSight)
            scene.analysis.observers = analyse::place_observers(
                list_observers(options, m_state->frame), scene, m_state->blocks);
        if (!options.weather.empty()) {
            if (kind != core::AnalysisKind::kEnergy)
                throw util::UsageError("analyse " + options.kind +
                                       ": weather; allowed: for energy alone");
            solar::use_weather(solar::read_weather(options.weather),
                               *solar::find_place(scene, world.centre), scene);
        }
        if (!options.horizon.empty()) {
            if (analysis.sky == analyse::SkyUse::kNone)
                throw util::UsageError("analyse " + options.kind +
                                       ": horizon; allowed: for sky, sun and energy");
            if (scene.analysis.range_m > 0)
                throw util::UsageError("analyse " + options.kind +
                                       ": horizon together with analysis.range_m, which ends "
                                       "before it; allowed: one of them");
            analyse::look_at_horizon({options.horizon}, world, scene);
        }
        const shade::View view = shade::make_view(scene, m_state->blocks, analyse::measure);
        const auto folder = util::TemporaryFolder::make("analyse " + options.kind);
        analyse::CellFile cells(folder.path() / "cells.tif", kind, grid.columns, grid.rows,
                                scene.quality.tile.in_picture(grid.columns));
        const std::size_t holes = render_tiles(*m_state, view, options.threads, control,
                                               static_cast<output::TileSink&>(cells));
        if (kind == core::AnalysisKind::kTerrain)
            analyse::derive_terrain(cells, grid.edge_m, {}, control.stop);
        Raster out = to_raster(cells, grid, m_state->frame);
        out.holes = call.checked(holes);
        return out;
    });
}

}  // namespace terravox
