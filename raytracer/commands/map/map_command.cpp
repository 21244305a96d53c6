#include "raytracer/commands/map/map_command.hpp"

#include <CLI/CLI.hpp>

#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "common/thread/parallel.hpp"
#include "common/thread/stop_signals.hpp"
#include "common/util/log.hpp"
#include "raytracer/analyse/raster/cell_grid.hpp"
#include "raytracer/commands/gaps.hpp"
#include "raytracer/commands/grid_arguments.hpp"
#include "raytracer/commands/map/map_file.hpp"
#include "raytracer/commands/render_pool_arguments.hpp"
#include "raytracer/commands/world_arguments.hpp"
#include "raytracer/render/picture_renderer.hpp"
#include "voxelserver/export/core/part.hpp"

namespace terravox::commands {
namespace {

struct MapArguments {
    WorldArguments world;
    RenderPoolArguments render_pool;
    GridArguments grid;
    std::string output;
    std::string tiles = "webp";
    pmtiles::MapTexts texts;
    std::string report;
    bool resume = false;
    bool quiet = false;
};

/// The scene of a map, without its camera: that depends on the world.
/// @throws UsageError for what only a picture in memory has
scene::Scene scene_of(const MapArguments& args) {
    scene::Scene scene = args.world.scene();
    if (scene.quality.time_s > 0)
        throw util::UsageError("map: --time is set; allowed: 0, a map has a number of samples");
    scene.quality.coarse_step = 1;
    scene.output.layers = core::PictureLayers::kBeauty;
    scene.output.tiff = core::TiffSamples::kByte;
    scene.output.denoise = false;
    return scene;
}

/// @throws UsageError for tiles that TIFF files cannot have
output::StreamShape shape_of(const scene::Scene& scene, const analyse::CellGrid& grid) {
    constexpr int kTiffTiles = 16;
    const int tile_px = scene.quality.tile.in_picture(grid.columns);
    if (tile_px % kTiffTiles != 0)
        throw util::UsageError("map: --tile " + std::to_string(tile_px) +
                               "; allowed: multiples of 16");
    return {grid.columns, grid.rows, tile_px, false};
}

util::ExitCode run_map(const MapArguments& args) {
    util::set_up_log(args.quiet ? "error" : args.world.log_level);
    const auto start = std::chrono::steady_clock::now();
    // Reject what cannot be written before any work is done.
    check_map_target(args.output);
    if (!args.report.empty())
        util::check_writable(args.report);
    exports::Selection selection;
    selection.area = area_of("map", args.grid);
    scene::Scene scene = scene_of(args);
    const MapFileOptions file{
        args.output, args.tiles == "png" ? pmtiles::TileFormat::kPng : pmtiles::TileFormat::kWebp,
        thread::thread_count(scene.processing.threads.value_or(0))};
    const render::RenderPoolOptions render_pool = args.render_pool.options(scene);

    const auto loaded = std::make_shared<render::LoadedWorld>(args.world.options(scene), scene);
    const voxel::WorldInfo& world = loaded->world->info();
    if (file.in_tiles() && world.crs_wkt.empty())
        throw util::UsageError("map: '" + world.title + "' has no place on Earth, so " +
                               args.output + " cannot have any; allowed: worlds with a CRS, .tif");
    // Voxels have textures and windows.
    constexpr double kFinestCell = 1.0 / 16;
    const analyse::CellGrid grid = analyse::grid_over(
        world, exports::part_of(world, selection).bounds, args.grid.resolution_m, kFinestCell);
    analyse::aim_at_cells(grid, world, scene);
    const output::StreamShape shape = shape_of(scene, grid);

    const thread::StopSignals signals;
    render::PictureRenderer renderer(loaded, render_pool, scene, args.quiet, signals.token());
    std::optional<MapFile> map;
    const auto begin = [&]() -> output::TileSink& {
        render::RenderStatistics known;
        known.counts.samples = static_cast<std::uint32_t>(scene.quality.samples);
        output::PictureInfo info = render::picture_info(renderer.view(), world, known, false);
        info.geo = analyse::placement_of(grid, world);
        map.emplace(file, shape, info);
        return map->sink();
    };
    std::uint64_t tiles = 0;
    const auto write = [&](const render::RenderStatistics& statistics) {
        const util::StageTimes::Scope timed(loaded->times, "write the map");
        pmtiles::MapTexts texts = args.texts;
        if (texts.title.empty())
            texts.title = world.title;
        if (texts.attribution.empty())
            texts.attribution = world.attribution;
        tiles = map->write(statistics.counts.holes.size(), texts,
                           [&] { return signals.token().stop_requested(); });
    };
    const render::RenderStatistics statistics =
        renderer.render_tiles(scene, args.output, begin, write, {args.resume, true, {}}, start);
    if (!args.report.empty())
        util::write_file_atomically(
            args.report,
            render::report_of(statistics, loaded->times, renderer.view()).dump(2) + "\n");
    if (!args.quiet) {
        render::print_statistics(statistics, loaded->times);
        std::printf("wrote %s: %d x %d cells of %g m", args.output.c_str(), grid.columns, grid.rows,
                    grid.edge_m);
        if (file.in_tiles())
            std::printf(", %llu tiles", static_cast<unsigned long long>(tiles));
        std::printf("\n");
    }
    return report_gaps(statistics, "map");
}

}  // namespace

std::function<util::ExitCode()> add_map_command(CLI::App& app) {
    auto args = std::make_shared<MapArguments>();
    CLI::App* command = app.add_subcommand(
        "map", "Draw a map of a world, as seen from above, as a GeoTIFF or tiles for the web");
    command->add_option("inputs", args->world.inputs, world_inputs_help())->required();
    command
        ->add_option("-o,--output", args->output,
                     "map to write: .tif (Cloud Optimized GeoTIFF in the world's CRS) or .pmtiles "
                     "(tiles of the web's map, EPSG:3857)")
        ->required();
    add_grid_arguments(*command, args->grid);
    command->add_option("--tiles", args->tiles, "of .pmtiles: webp, or png, which loses nothing")
        ->check(CLI::IsMember({"webp", "png"}))
        ->capture_default_str();
    command->add_option("--title", args->texts.title, "of .pmtiles; default: that of the world");
    command->add_option("--attribution", args->texts.attribution,
                        "of .pmtiles: whose data it shows; default: that of the world");
    command->add_option("--report", args->report, "write times and counts to this file (JSON)");
    command->add_flag("--resume", args->resume,
                      "keep finished tiles in OUT.tiles until the map is finished, and go on with "
                      "those that are there");
    command->add_flag("-q,--quiet", args->quiet, "print errors only");
    add_opening_arguments(
        *command, args->world,
        {"world", "generated", "processing", "sun", "sky", "quality", "output.exposure_ev",
         "output.adaptation", "output.tone", "output.credit"});
    add_render_pool_arguments(*command, args->render_pool);
    return [args] { return run_map(*args); };
}

}  // namespace terravox::commands
