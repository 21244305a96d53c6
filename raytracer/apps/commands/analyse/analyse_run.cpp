#include "raytracer/apps/commands/analyse/analyse_run.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <memory>
#include <utility>

#include "common/thread/parallel.hpp"
#include "common/thread/stop.hpp"
#include "common/util/log.hpp"
#include "raytracer/analyse/evaluators/analysis.hpp"
#include "raytracer/analyse/raster/cell_file.hpp"
#include "raytracer/analyse/raster/shadow_cube.hpp"
#include "raytracer/analyse/raster/sight_summary.hpp"
#include "raytracer/analyse/solar/place_and_clock.hpp"
#include "raytracer/analyse/solar/weather.hpp"
#include "voxelserver/out/export/core/job.hpp"

namespace terravox::commands {
namespace {

/// Seconds, as find_instant().
using ToInstant = std::function<std::int64_t(const ClockTime&)>;

/// The dimension of a cube must rise; bands have any order.
std::vector<ClockTime> times_for(const AnalyseArguments& args, const ToInstant& instant_s) {
    std::vector<ClockTime> times = parse_clock_times(args.sun.times);
    if (analyse::ShadowCube::is_netcdf(args.output))
        std::sort(times.begin(), times.end(), [&](const ClockTime& a, const ClockTime& b) {
            return instant_s(a) < instant_s(b);
        });
    return times;
}

std::vector<analyse::ShadowCube::Mask> make_masks(const std::vector<ClockTime>& times,
                                                  const ToInstant& instant_s) {
    std::vector<analyse::ShadowCube::Mask> masks;
    for (const ClockTime& time : times) {
        if (!masks.empty() && masks.back().time_s == instant_s(time))
            throw util::UsageError("analyse sun: --times has one instant as " + masks.back().name +
                                   " and " + time.band + "; allowed: each instant once");
        masks.push_back({time.band, instant_s(time)});
    }
    return masks;
}

/// Rejects options that masks of several instants cannot have.
/// @throws UsageError
void check_times_arguments(const AnalyseArguments& args) {
    if (args.sun.times.empty())
        return;
    if (args.resume || !args.part.empty())
        throw util::UsageError(std::string("analyse sun: --times together with ") +
                               (args.resume ? "--resume" : "--part") + "; allowed: one of them");
    if (!args.reports.page.empty() || !args.reports.map.empty())
        throw util::UsageError(
            "analyse sun: --times together with --report or --map; allowed: these with --at");
}

/// Measures and writes shadow masks of several instants (`--times`), each rendered as a raster of
/// its own.
/// @param scene of the analysis, with its camera
/// @param loaded with a place on Earth
/// @return of all rasters together
/// @throws UsageError for an instant that is there twice; Error, also "interrupted"
render::RenderStatistics write_shadow_times(const AnalyseArguments& args, const scene::Scene& scene,
                                            const analyse::CellGrid& grid,
                                            const render::LoadedWorld& loaded,
                                            render::PictureRenderer& renderer) {
    const voxel::WorldInfo& world = loaded.world->info();
    const geo::MapPlace place = *solar::find_place(scene, world.centre);
    const ToInstant instant_s = [&](const ClockTime& time) {
        return find_instant(scene_at(scene, time), place);
    };
    const std::vector<ClockTime> times = times_for(args, instant_s);
    analyse::ShadowCube cube(args.output, make_masks(times, instant_s), grid.columns, grid.rows);
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
    info.geo = analyse::make_placement(grid, world);
    cube.write(args.output, info, thread::thread_count(scene.processing.threads.value_or(0)));
    return statistics;
}

/// The scene of an analysis, without its camera: that depends on the world.
scene::Scene make_scene(const AnalyseArguments& args, core::AnalysisKind kind) {
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

/// @return nullopt for the whole raster
/// @throws UsageError for what is no part, and for files that only a whole raster has
std::optional<farm::Part> make_part(const AnalyseArguments& args) {
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

class AnalyseRun {
public:
    AnalyseRun(const AnalyseArguments& args, core::AnalysisKind kind)
        : m_args(args), m_kind(kind) {}

    util::ExitCode run() {
        const RenderPool pool = check_arguments();
        open_world();
        place_grid();
        complete_scene();
        const thread::StopSignals signals;
        render::PictureRenderer renderer(m_loaded, pool, m_scene,
                                         m_args.verbosity.quiet || m_args.as_json, signals.token());
        if (!m_args.sun.times.empty())
            return report(write_shadow_times(m_args, m_scene, m_grid, *m_loaded, renderer));
        return make_raster(renderer, signals.token());
    }

private:
    using RenderPool = render::RenderPoolOptions;

    /// Rejects what cannot be before any work is done.
    RenderPool check_arguments() {
        check_report_targets(m_args.reports);
        check_times_arguments(m_args);
        m_selection.area = parse_area("analyse", m_args.grid);
        m_scene = make_scene(m_args, m_kind);
        (void)make_relief(m_scene);
        m_part = make_part(m_args);
        check_object_arguments(m_args.objects, m_scene, !m_args.facades.file.empty());
        check_facade_arguments(m_args.facades, m_scene, m_part.has_value());
        check_horizon_arguments(m_args.horizon, m_scene);
        m_weather = read_weather(m_args.weather, m_args.world);
        return m_args.render_pool.options(m_scene);
    }

    void open_world() {
        m_loaded = std::make_shared<render::LoadedWorld>(m_args.world.options(m_scene), m_scene);
        if (analyse::find_analysis(m_kind).sun != analyse::SunUse::kNone && !world().centre)
            throw util::UsageError("analyse " + std::string(core::to_word(m_kind)) + ": '" +
                                   world().title +
                                   "' has no place on Earth; allowed: worlds with a CRS");
    }

    void place_grid() {
        m_grid = analyse::grid_over(world(), exports::make_part(world(), m_selection).bounds,
                                    m_args.grid.resolution_m);
        analyse::look_at_cells(m_grid, world(), m_scene);
    }

    /// What the scene takes from files and from the world.
    void complete_scene() {
        if (m_weather)
            solar::use_weather(*m_weather, *solar::find_place(m_scene, world().centre), m_scene);
        use_horizon(m_args.horizon, world(), m_scene);
        if (!m_args.objects.file.empty() || !m_args.objects.polygons.empty())
            m_objects.emplace(m_args.objects, m_scene, m_grid, world());
        if (m_kind == core::AnalysisKind::kSight)
            m_scene.analysis.observers = analyse::place_observers(
                parse_observers(m_args.observers, world()), m_scene, m_loaded->blocks);
    }

    util::ExitCode make_raster(render::PictureRenderer& renderer, const std::stop_token& stop) {
        std::optional<analyse::CellFile> cells;
        std::optional<analyse::SightSummary> seen;
        const auto begin = [&]() -> output::TileSink& {
            cells.emplace(m_args.output, m_scene.analysis.kind, m_grid.columns, m_grid.rows,
                          m_scene.quality.tile.in_picture(m_grid.columns));
            return *cells;
        };
        const auto write = [&](const render::RenderStatistics& statistics) {
            seen = write_cells(*cells, renderer, statistics, stop);
        };
        const render::KeepOptions keep{m_args.resume, true, m_part};
        render::RenderStatistics statistics =
            m_part ? renderer.render(m_scene, {m_args.output}, keep, m_start)
                   : renderer.render_tiles(m_scene, m_args.output, begin, write, keep, m_start);
        if (!m_args.facades.file.empty()) {
            const std::vector<analyse::ObjectPolygon> polygons = polygons_given();
            make_facades(m_args.facades, {m_scene, m_grid, world(), renderer, stop, polygons},
                         *cells, statistics);
        }
        const util::ExitCode code = report(statistics);
        if (seen)
            print(*seen);
        return code;
    }

    std::optional<analyse::SightSummary> write_cells(analyse::CellFile& cells,
                                                     const render::PictureRenderer& renderer,
                                                     const render::RenderStatistics& statistics,
                                                     const std::stop_token& stop) {
        const util::StageTimes::Scope timed(m_loaded->times, "write the raster");
        output::PictureInfo info =
            render::picture_info(renderer.view(), world(), statistics, false);
        const Reported what{world(),        m_scene,
                            m_grid,         m_args.world.additions,
                            m_args.weather, statistics.counts.holes.size()};
        return write_outputs(cells, {m_args.output, m_args.reports, m_objects}, what,
                             std::move(info),
                             thread::thread_count(m_scene.processing.threads.value_or(0)), stop);
    }

    util::ExitCode report(const render::RenderStatistics& statistics) const {
        if (!m_args.verbosity.quiet && (m_part || !m_args.as_json)) {
            if (m_args.verbosity.verbose)
                render::print_statistics(statistics, m_loaded->times);
            print_files(statistics);
        }
        return report_gaps(statistics, "raster");
    }

    void print_files(const render::RenderStatistics& statistics) const {
        if (m_part) {
            std::printf("wrote %s in %.1f s: terravox merge makes a raster of all parts\n",
                        farm::checkpoint_path(m_args.output, m_part).c_str(), statistics.seconds);
            return;
        }
        std::printf("wrote %s in %.1f s\n", m_args.output.c_str(), statistics.seconds);
        for (const std::string& file :
             {m_args.objects.file, m_args.facades.file, m_args.reports.map, m_args.reports.page})
            if (!file.empty())
                std::printf("wrote %s\n", file.c_str());
    }

    void print(const analyse::SightSummary& seen) const {
        if (m_args.as_json)
            std::printf("%s\n", analyse::to_json(seen).c_str());
        else if (!m_args.verbosity.quiet)
            std::printf("%s", analyse::make_table(seen).c_str());
    }

    [[nodiscard]] const voxel::WorldInfo& world() const { return m_loaded->world->info(); }
    [[nodiscard]] std::vector<analyse::ObjectPolygon> polygons_given() const {
        return m_objects ? m_objects->polygons() : std::vector<analyse::ObjectPolygon>{};
    }

    const AnalyseArguments& m_args;
    const core::AnalysisKind m_kind;
    const std::chrono::steady_clock::time_point m_start = std::chrono::steady_clock::now();
    scene::Scene m_scene;
    exports::Selection m_selection;
    std::optional<farm::Part> m_part;
    std::optional<solar::WeatherFile> m_weather;
    std::shared_ptr<render::LoadedWorld> m_loaded;
    analyse::CellGrid m_grid;
    std::optional<PlannedObjects> m_objects;
};

}  // namespace

util::ExitCode run_analyse(const AnalyseArguments& args, core::AnalysisKind kind) {
    util::set_up_log(args.verbosity.quiet ? "error" : args.world.log_level);
    if (args.sun.times.empty())
        analyse::check_raster_target(args.output);
    else
        analyse::ShadowCube::check_target(args.output);
    return AnalyseRun(args, kind).run();
}

}  // namespace terravox::commands
