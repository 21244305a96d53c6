#include "raytracer/apps/commands/analyse/shadow_times.hpp"

#include <algorithm>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/thread/parallel.hpp"
#include "common/util/error.hpp"
#include "raytracer/analyse/raster/cell_file.hpp"
#include "raytracer/analyse/raster/shadow_cube.hpp"
#include "raytracer/analyse/solar/analysis_place.hpp"
#include "raytracer/apps/commands/analyse/time_arguments.hpp"

namespace terravox::commands {
namespace {

/// Seconds, as instant_of().
using InstantOf = std::function<std::int64_t(const ClockTime&)>;

/// The dimension of a cube must rise; bands have any order.
std::vector<ClockTime> times_for(const AnalyseArguments& args, const InstantOf& instant_s) {
    std::vector<ClockTime> times = times_of(args.sun.times);
    if (analyse::ShadowCube::is_netcdf(args.output))
        std::sort(times.begin(), times.end(), [&](const ClockTime& a, const ClockTime& b) {
            return instant_s(a) < instant_s(b);
        });
    return times;
}

std::vector<analyse::ShadowCube::Mask> masks_of(const std::vector<ClockTime>& times,
                                                const InstantOf& instant_s) {
    std::vector<analyse::ShadowCube::Mask> masks;
    for (const ClockTime& time : times) {
        if (!masks.empty() && masks.back().time_s == instant_s(time))
            throw util::UsageError("analyse sun: --times has one instant as " + masks.back().name +
                                   " and " + time.band + "; allowed: each instant once");
        masks.push_back({time.band, instant_s(time)});
    }
    return masks;
}

}  // namespace

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

render::RenderStatistics write_shadow_times(const AnalyseArguments& args, const scene::Scene& scene,
                                            const analyse::CellGrid& grid,
                                            const render::LoadedWorld& loaded,
                                            render::PictureRenderer& renderer) {
    const voxel::WorldInfo& world = loaded.world->info();
    const geo::MapPlace place = *solar::place_of(scene, world.centre);
    const InstantOf instant_s = [&](const ClockTime& time) {
        return instant_of(scene_at(scene, time), place);
    };
    const std::vector<ClockTime> times = times_for(args, instant_s);
    analyse::ShadowCube cube(args.output, masks_of(times, instant_s), grid.columns, grid.rows);
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
    return statistics;
}

}  // namespace terravox::commands
