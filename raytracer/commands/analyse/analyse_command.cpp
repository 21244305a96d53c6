#include "raytracer/commands/analyse/analyse_command.hpp"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <array>
#include <cstdio>
#include <memory>
#include <optional>

#include "common/thread/parallel.hpp"
#include "common/thread/stop_signals.hpp"
#include "common/util/log.hpp"
#include "raytracer/analyse/raster/cell_grid.hpp"
#include "raytracer/analyse/raster/raster.hpp"
#include "raytracer/analyse/raster/shadow_cube.hpp"
#include "raytracer/analyse/raster/sight_summary.hpp"
#include "raytracer/commands/analyse/facade_arguments.hpp"
#include "raytracer/commands/analyse/horizon_arguments.hpp"
#include "raytracer/commands/analyse/object_arguments.hpp"
#include "raytracer/commands/analyse/observer_arguments.hpp"
#include "raytracer/commands/analyse/raster_outputs.hpp"
#include "raytracer/commands/analyse/report_arguments.hpp"
#include "raytracer/commands/analyse/sun_arguments.hpp"
#include "raytracer/commands/analyse/time_arguments.hpp"
#include "raytracer/commands/analyse/weather_arguments.hpp"
#include "raytracer/commands/gaps.hpp"
#include "raytracer/commands/grid_arguments.hpp"
#include "raytracer/commands/render_pool_arguments.hpp"
#include "raytracer/commands/world_arguments.hpp"
#include "raytracer/render/picture_renderer.hpp"
#include "raytracer/solar/analysis_place.hpp"
#include "raytracer/solar/use_weather.hpp"
#include "voxelserver/export/core/part.hpp"

namespace terravox::commands {
namespace {

/// Arguments of all analyses, and those of terrain and sight.
struct AnalyseArguments {
    WorldArguments world;
    RenderPoolArguments render_pool;
    std::string output;
    GridArguments grid;
    std::optional<int> level;
    ObserverArguments observers;
    ObjectArguments objects;
    ReportArguments reports;
    bool as_json = false;
    SunArguments sun;
    std::string weather;
    HorizonArguments horizon;
    FacadeArguments facades;
    std::string part;
    bool resume = false;
    bool quiet = false;
};

/// The scene of an analysis, without its camera: that depends on the world.
scene::Scene scene_of(const AnalyseArguments& args, core::AnalysisKind kind) {
    scene::Scene scene = args.world.scene();
    scene.analysis.kind = kind;
    if (kind == core::AnalysisKind::kSun)
        choose_sun_kind(args.sun, args.world, scene);
    if (kind == core::AnalysisKind::kEnergy)
        refuse_day_and_period("energy", args.world, scene);
    scene.quality.level = 0;
    // A voxel covers at most a cell.
    scene.quality.detail = 1;
    if (args.level) {
        scene.quality.level = *args.level;
        scene.quality.detail = 0;
    }
    return scene;
}

util::ExitCode report(const AnalyseArguments& args, const render::RenderStatistics& statistics,
                      const util::StageTimes& times) {
    if (!args.quiet && !args.part.empty()) {
        render::print_statistics(statistics, times);
        std::printf("wrote %s: terravox merge makes a raster of all parts\n",
                    farm::checkpoint_path(args.output, farm::Part::parse(args.part)).c_str());
    } else if (!args.quiet && !args.as_json) {
        render::print_statistics(statistics, times);
        for (const std::string& file : {args.output, args.objects.file, args.facades.file,
                                        args.reports.map, args.reports.page})
            if (!file.empty())
                std::printf("wrote %s\n", file.c_str());
    }
    return report_gaps(statistics, "raster");
}

}  // namespace

std::vector<std::string> own_fields(core::AnalysisKind kind) {
    switch (kind) {
        case core::AnalysisKind::kTerrain:
            return {"analysis.relief", "analysis.window", "analysis.fill_m",
                    "analysis.relief_light"};
        case core::AnalysisKind::kSky:
            return {"analysis.surface", "analysis.thin_blocks", "analysis.directions",
                    "analysis.range_m"};
        case core::AnalysisKind::kShadow:
            return {"analysis.surface", "analysis.thin_blocks", "sun.date", "sun.time_h",
                    "sun.zone",         "sun.utc_offset_h"};
        case core::AnalysisKind::kSun:
        case core::AnalysisKind::kSunPeriod:
        case core::AnalysisKind::kSunMonths:
            return {
                "analysis.surface", "analysis.thin_blocks", "analysis.step_min", "analysis.from",
                "analysis.to",      "analysis.bin_deg",     "sun.date",          "sun.zone",
                "sun.utc_offset_h"};
        case core::AnalysisKind::kEnergy:
            return {"analysis.surface",
                    "analysis.thin_blocks",
                    "analysis.directions",
                    "analysis.step_min",
                    "analysis.from",
                    "analysis.to",
                    "analysis.bin_deg",
                    "analysis.linke",
                    "analysis.diffuse",
                    "analysis.albedo",
                    "analysis.crown_light",
                    "analysis.storey_m",
                    "sun.date",
                    "sun.zone",
                    "sun.utc_offset_h"};
        case core::AnalysisKind::kSight:
            return {"analysis.surface", "analysis.range_m", "analysis.target_m",
                    "analysis.curvature", "analysis.refraction"};
        default: return {};
    }
}

namespace {

/// @return nullopt for the whole raster
/// @throws UsageError for what is no part, and for files that only a whole raster has
std::optional<farm::Part> part_of(const AnalyseArguments& args) {
    if (args.part.empty())
        return std::nullopt;
    const std::optional<farm::Part> part = farm::Part::parse(args.part);
    if (!part)
        throw util::UsageError("analyse: --part " + args.part +
                               "; allowed: " + farm::Part::kAllowed);
    const std::array<std::pair<const char*, bool>, 4> of_all = {
        {{"--report", !args.reports.page.empty()},
         {"--map", !args.reports.map.empty()},
         {"--objects", !args.objects.file.empty()},
         {"--json", args.as_json}}};
    for (const auto& [option, is_given] : of_all)
        if (is_given)
            throw util::UsageError(std::string("analyse: --part with ") + option +
                                   ", which needs all parts; allowed: " + option +
                                   " of terravox merge");
    return part;
}

void refuse_with_times(const AnalyseArguments& args) {
    if (args.sun.times.empty())
        return;
    if (args.resume || !args.part.empty())
        throw util::UsageError(std::string("analyse sun: --times together with ") +
                               (args.resume ? "--resume" : "--part") + "; allowed: one of them");
    if (!args.reports.page.empty() || !args.reports.map.empty())
        throw util::UsageError(
            "analyse sun: --times together with --report or --map; allowed: these with --at");
}

/// Shadow masks of several instants: each is rendered as a raster of its own.
util::ExitCode run_times(const AnalyseArguments& args, const scene::Scene& scene,
                         const analyse::CellGrid& grid, render::LoadedWorld& loaded,
                         render::PictureRenderer& renderer) {
    const voxel::WorldInfo& world = loaded.world->info();
    const geo::MapPlace place = *solar::place_of(scene, world.centre);
    std::vector<ClockTime> times = times_of(args.sun.times);
    const auto instant_s = [&](const ClockTime& time) {
        return instant_of(scene_at(scene, time), place);
    };
    // The dimension of a cube must rise; bands have any order.
    if (analyse::ShadowCube::is_netcdf(args.output))
        std::sort(times.begin(), times.end(), [&](const ClockTime& a, const ClockTime& b) {
            return instant_s(a) < instant_s(b);
        });
    std::vector<analyse::ShadowCube::Mask> masks;
    for (const ClockTime& time : times) {
        if (!masks.empty() && masks.back().time_s == instant_s(time))
            throw util::UsageError("analyse sun: --times has one instant as " + masks.back().name +
                                   " and " + time.band + "; allowed: each instant once");
        masks.push_back({time.band, instant_s(time)});
    }
    analyse::ShadowCube cube(args.output, std::move(masks), grid.columns, grid.rows);
    render::RenderStatistics statistics;
    render::RenderStatistics earlier;
    for (std::size_t i = 0; i < times.size(); ++i) {
        const scene::Scene at = scene_at(scene, times[i]);
        std::optional<analyse::CellFile> cells;
        const auto begin = [&]() -> output::TileSink& {
            cells.emplace(args.output, at.analysis.kind, grid.columns, grid.rows,
                          at.quality.tile.in_picture(grid.columns));
            return *cells;
        };
        const auto write = [&](const render::RenderStatistics&) { cube.take(i, *cells); };
        statistics = renderer.render_tiles(at, args.output, begin, write, {false, true, {}});
        statistics.counts.add(earlier.counts);
        statistics.seconds += earlier.seconds;
        earlier = statistics;
    }
    output::PictureInfo info = render::picture_info(renderer.view(), world, statistics, false);
    info.geo = analyse::placement_of(grid, world);
    cube.write(args.output, info, thread::thread_count(scene.processing.threads.value_or(0)));
    return report(args, statistics, loaded.times);
}

util::ExitCode run_analyse(const AnalyseArguments& args, core::AnalysisKind kind) {
    util::set_up_log(args.quiet ? "error" : args.world.log_level);
    const auto start = std::chrono::steady_clock::now();
    // Reject what cannot be written before any work is done.
    if (args.sun.times.empty())
        analyse::check_raster_target(args.output);
    else
        analyse::ShadowCube::check_target(args.output);
    check_report_targets(args.reports);
    refuse_with_times(args);
    exports::Selection selection;
    selection.area = area_of("analyse", args.grid);
    scene::Scene scene = scene_of(args, kind);
    (void)relief_of(scene);
    const std::optional<farm::Part> part = part_of(args);
    check_object_arguments(args.objects, scene, !args.facades.file.empty());
    check_facade_arguments(args.facades, scene, part.has_value());
    check_horizon_arguments(args.horizon, scene);
    const std::optional<solar::WeatherFile> weather = read_weather(args.weather, args.world);
    const render::RenderPoolOptions render_pool = args.render_pool.options(scene);

    const auto loaded = std::make_shared<render::LoadedWorld>(args.world.options(scene), scene);
    const voxel::WorldInfo& world = loaded->world->info();
    if ((core::needs_sun_way(kind) || kind == core::AnalysisKind::kEnergy) && !world.centre)
        throw util::UsageError("analyse " + std::string(core::word_of(kind)) + ": '" + world.title +
                               "' has no place on Earth; allowed: worlds with a CRS");
    const analyse::CellGrid grid = analyse::grid_over(
        world, exports::part_of(world, selection).bounds, args.grid.resolution_m);
    analyse::look_at_cells(grid, world, scene);
    if (weather)
        solar::use_weather(*weather, *solar::place_of(scene, world.centre), scene);
    use_horizon(args.horizon, world, scene);
    std::optional<PlannedObjects> objects;
    if (!args.objects.file.empty() || !args.objects.polygons.empty())
        objects.emplace(args.objects, scene, grid, world);
    const std::vector<analyse::ObjectPolygon> polygons =
        objects ? objects->polygons() : std::vector<analyse::ObjectPolygon>{};
    if (kind == core::AnalysisKind::kSight)
        scene.analysis.observers =
            analyse::place_observers(observers_of(args.observers, world), scene, loaded->blocks);

    const thread::StopSignals signals;
    render::PictureRenderer renderer(loaded, render_pool, scene, args.quiet || args.as_json,
                                     signals.token());
    if (!args.sun.times.empty())
        return run_times(args, scene, grid, *loaded, renderer);
    std::optional<analyse::CellFile> cells;
    std::optional<analyse::SightSummary> seen;
    const auto begin = [&]() -> output::TileSink& {
        cells.emplace(args.output, scene.analysis.kind, grid.columns, grid.rows,
                      scene.quality.tile.in_picture(grid.columns));
        return *cells;
    };
    const auto write = [&](const render::RenderStatistics& statistics) {
        const util::StageTimes::Scope timed(loaded->times, "write the raster");
        output::PictureInfo info = render::picture_info(renderer.view(), world, statistics, false);
        const Reported what{world,
                            scene,
                            grid,
                            own_fields(scene.analysis.kind),
                            args.world.additions,
                            args.weather,
                            statistics.counts.holes.size()};
        seen = write_outputs(*cells, {args.output, args.reports, objects}, what, std::move(info),
                             thread::thread_count(scene.processing.threads.value_or(0)),
                             signals.token());
    };
    const render::KeepOptions keep{args.resume, true, part};
    render::RenderStatistics statistics =
        part ? renderer.render(scene, {args.output}, keep, start)
             : renderer.render_tiles(scene, args.output, begin, write, keep, start);
    if (!args.facades.file.empty())
        make_facades(args.facades, {scene, grid, world, renderer, signals.token(), polygons},
                     *cells, statistics);
    const util::ExitCode code = report(args, statistics, loaded->times);
    if (seen && args.as_json)
        std::printf("%s\n", analyse::json_of(*seen).c_str());
    else if (seen && !args.quiet)
        std::printf("%s", analyse::table_of(*seen).c_str());
    return code;
}

CLI::App* add_kind(CLI::App& group, AnalyseArguments& args, core::AnalysisKind kind,
                   const std::string& description) {
    CLI::App* command = group.add_subcommand(std::string(core::word_of(kind)), description);
    command->add_option("inputs", args.world.inputs, world_inputs_help())->required();
    command->add_option("-o,--output", args.output, "raster to write: a Cloud Optimized GeoTIFF")
        ->required();
    add_grid_arguments(*command, args.grid);
    command
        ->add_option("--level", args.level,
                     "level of the world's voxels; default: the coarsest whose voxels are no "
                     "larger than a cell")
        ->check(CLI::Range(0, 20));
    command->add_flag("--resume", args.resume,
                      "keep finished tiles in OUT.tif.tiles until the raster is finished, and go "
                      "on with those that are there");
    command->add_option("--part", args.part,
                        "I/N: only part I of N of the tiles, kept for terravox merge; no raster");
    add_report_options(*command, args.reports);
    command->add_flag("-q,--quiet", args.quiet, "print errors only");
    std::vector<std::string> sections = own_fields(kind);
    sections.insert(sections.end(), {"world", "generated", "processing", "quality.tile"});
    add_opening_arguments(*command, args.world, sections);
    add_render_pool_arguments(*command, args.render_pool);
    return command;
}

void add_sight_options(CLI::App& command, AnalyseArguments& args) {
    command
        .add_option("--observer", args.observers.texts,
                    std::string("who looks; may be given several times: ") + kObserverForms)
        ->expected(1)
        ->take_all()
        ->allow_extra_args(false);
    command.add_option("--observers", args.observers.files, kObserverFileForm)
        ->expected(1)
        ->take_all()
        ->allow_extra_args(false);
    command
        .add_option("--observer-step-m", args.observers.step_m,
                    "distance of the observers on a line, metres")
        ->check(CLI::Range(0.1, 1e5))
        ->capture_default_str();
    command.add_flag("--json", args.as_json,
                     "print what is seen, by material and class, as one JSON object");
}

}  // namespace

std::function<util::ExitCode()> add_analyse_command(CLI::App& app) {
    CLI::App* group = app.add_subcommand("analyse", "Measure a world: rasters for GIS, as GeoTIFF");
    group->require_subcommand(1);
    struct Kind {
        core::AnalysisKind kind;
        const char* description;
        AnalyseArguments args{};
        CLI::App* command = nullptr;
    };
    using core::AnalysisKind;
    const auto kinds = std::make_shared<std::array<Kind, 5>>(std::array<Kind, 5>{{
        {AnalysisKind::kTerrain,
         "Heights of surface and ground, slope, aspect, hillshade, class, material, colour"},
        {AnalysisKind::kSky, "How much of the sky is seen: sky-view factor, openness"},
        {AnalysisKind::kSun,
         "Hours of direct sun on a day or in a period, or where it shines at an instant"},
        {AnalysisKind::kEnergy,
         "Energy of sun and sky on a day or in a period, on roofs and ground as they lie"},
        {AnalysisKind::kSight, "What observers see, and from where they are seen: viewsheds"},
    }});
    for (Kind& kind : *kinds) {
        kind.command = add_kind(*group, kind.args, kind.kind, kind.description);
        if (kind.kind == AnalysisKind::kSun)
            add_sun_options(*kind.command, kind.args.sun);
        if (kind.kind == AnalysisKind::kSun || kind.kind == AnalysisKind::kEnergy ||
            kind.kind == AnalysisKind::kSky)
            add_horizon_options(*kind.command, kind.args.horizon);
        if (kind.kind == AnalysisKind::kEnergy) {
            add_weather_option(*kind.command, kind.args.weather);
            add_object_options(*kind.command, kind.args.objects);
            add_facade_options(*kind.command, kind.args.facades);
        }
        if (kind.kind == AnalysisKind::kSight)
            add_sight_options(*kind.command, kind.args);
    }
    return [kinds] {
        for (const Kind& kind : *kinds)
            if (kind.command->parsed())
                return run_analyse(kind.args, kind.kind);
        throw util::UsageError("analyse: no kind; --help lists them");
    };
}

}  // namespace terravox::commands
