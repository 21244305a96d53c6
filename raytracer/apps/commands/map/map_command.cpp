#include <chrono>
#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "common/thread/parallel.hpp"
#include "common/thread/stop.hpp"
#include "common/util/atomic_file.hpp"
#include "common/util/command_line.hpp"
#include "common/util/log.hpp"
#include "common/util/text.hpp"
#include "raytracer/analyse/raster/cell_grid.hpp"
#include "raytracer/apps/commands/arguments/world_arguments.hpp"
#include "raytracer/apps/commands/commands.hpp"
#include "raytracer/apps/commands/run_arguments.hpp"
#include "raytracer/apps/pmtiles/map_tiles.hpp"
#include "raytracer/core/output/gdal_writing.hpp"
#include "raytracer/core/output/tile_stream.hpp"
#include "raytracer/core/scene/scene.hpp"
#include "raytracer/farm/render/picture_renderer.hpp"
#include "voxelserver/out/export/core/job.hpp"

namespace terravox::commands {
namespace {

std::filesystem::path with_ending(std::filesystem::path file, const char* ending) {
    return file.replace_extension(ending);
}

/// How the file of a map is written.
struct MapFileOptions {
    std::filesystem::path file;  ///< .tif, .tiff or .pmtiles
    pmtiles::TileFormat tiles = pmtiles::TileFormat::kWebp;
    int threads = 1;
    bool quiet = false;                ///< shows no progress
    pmtiles::WebArea area;             ///< of .pmtiles
    std::function<bool()> is_stopped;  ///< asked now and then, in any thread

    [[nodiscard]] bool in_tiles() const { return util::lower_extension(file) == ".pmtiles"; }
};

/// @throws UsageError for another ending; Error where the file cannot be written, or its tiles
/// cannot be made here
void check_map_target(const MapFileOptions& options) {
    const std::string ending = util::lower_extension(options.file);
    if (ending != ".tif" && ending != ".tiff" && ending != ".pmtiles")
        throw util::UsageError("write the map " + options.file.string() + ": the ending '" +
                               ending + "'; allowed: .tif .tiff .pmtiles");
    util::check_writable(options.file);
    if (options.in_tiles())
        pmtiles::check_tile_format(options.tiles);
}

/// Writes the file of a map: collects finished tiles of the picture in a temporary file next to it,
/// which is removed in the end. Not thread-safe.
class MapFile {
public:
    /// @param shape whose tiles have a multiple of 16 pixels
    /// @throws Error when the temporary file cannot be written
    MapFile(MapFileOptions options, const output::StreamShape& shape,
            const output::PictureInfo& info)
        : m_options(std::move(options)) {
        m_picture.emplace(with_ending(m_options.file, ".picture.tif"));
        m_stream = std::make_unique<output::TileStream>(m_picture->temporary_path(), shape, info);
    }
    [[nodiscard]] output::TileSink& sink() noexcept { return *m_stream; }
    /// Writes the target from the finished picture.
    /// @param texts of a PMTiles archive, and holes
    /// @return how many tiles a PMTiles archive has; 0 for a GeoTIFF
    /// @throws Error, also "interrupted"
    std::uint64_t write(const pmtiles::MapTexts& texts) {
        m_stream->finish(texts.holes);
        if (!m_options.in_tiles()) {
            util::AtomicFile target(m_options.file);
            write_overviews(target.temporary_path());
            target.commit();
            return 0;
        }
        // Coarse tiles are made of the overviews.
        const util::AtomicFile map(with_ending(m_options.file, ".map.tif"));
        write_overviews(map.temporary_path());
        return pmtiles::write_map_tiles(map.temporary_path(), m_options.area, m_options.file,
                                        m_options.tiles, texts, m_options.threads, m_options.quiet,
                                        m_options.is_stopped);
    }

private:
    /// Writes the picture with overviews, and removes it.
    void write_overviews(const std::filesystem::path& to) {
        const output::GdalWatch watch("write the map " + m_options.file.string());
        output::GdalDataset picture(
            GDALOpen(m_picture->temporary_path().string().c_str(), GA_ReadOnly));
        watch.check(picture != nullptr);
        output::CogOptions options;
        options.threads = std::to_string(m_options.threads);
        options.is_stopped = m_options.is_stopped;
        output::write_cog(picture.get(), to, options, watch);
        picture.reset();
        m_picture.reset();
    }

    MapFileOptions m_options;
    std::optional<util::AtomicFile> m_picture;  ///< never committed: its destructor removes it
    std::unique_ptr<output::TileStream> m_stream;
};

struct MapArguments {
    WorldArguments world;
    RenderPoolArguments render_pool;
    GridArguments grid;
    std::string output;
    std::string tiles;
    std::string zooms;
    int tile_px = 0;
    std::string title;
    std::string attribution;
    std::string report;
    bool resume = false;
    Verbosity verbosity;
};

/// The scene of a map, without its camera: that depends on the world.
/// @throws UsageError for an analysis, and for what only a picture in memory has
scene::Scene make_scene(const MapArguments& args) {
    scene::Scene scene = args.world.scene();
    scene::check_is_picture(scene);
    if (scene.quality.time_s > 0)
        throw util::UsageError("map: --time is set; allowed: 0, a map has a number of samples");
    if (scene.output.denoise)
        throw util::UsageError("map: output.denoise = true; allowed: false");
    scene.quality.coarse_step = 1;
    scene.output.layers = core::PictureLayers::kBeauty;
    scene.output.tiff = core::TiffSamples::kByte;
    return scene;
}

/// @throws UsageError for tiles that TIFF files cannot have, or whose memory would add up
output::StreamShape make_shape(const scene::Scene& scene, const analyse::CellGrid& grid) {
    constexpr int kTiffTiles = 16;
    constexpr int kMost_px = 512;
    const int tile_px = scene.quality.tile.in_picture(grid.columns);
    if (tile_px % kTiffTiles != 0 || tile_px > kMost_px)
        throw util::UsageError("map: --tile " + std::to_string(tile_px) +
                               "; allowed: multiples of 16 up to " + std::to_string(kMost_px));
    return {grid.columns, grid.rows, tile_px, false};
}

/// Those of --zooms, which must be given; whether the map has them is not known yet.
/// @throws UsageError
util::IntRange read_zooms(const MapArguments& args) {
    return util::parse_range("map: --zooms", args.zooms, {0, pmtiles::TileAddress::kMaxZoom});
}

/// @throws UsageError for what a GeoTIFF has not, and for zooms that are none
MapFileOptions make_file(const MapArguments& args, const scene::Scene& scene) {
    MapFileOptions out;
    out.file = args.output;
    const auto only_of_tiles = [&](const char* flag, const std::string& value) {
        if (!value.empty() && !out.in_tiles())
            throw util::UsageError(std::string("map: ") + flag + " " + value + " of " +
                                   args.output + "; allowed: with -o FILE.pmtiles");
    };
    only_of_tiles("--tiles", args.tiles);
    only_of_tiles("--zooms", args.zooms);
    if (!args.zooms.empty())
        (void)read_zooms(args);
    only_of_tiles("--tiles-px", args.tile_px > 0 ? std::to_string(args.tile_px) : "");
    out.quiet = args.verbosity.quiet;
    if (args.tiles == "png")
        out.tiles = pmtiles::TileFormat::kPng;
    out.threads = thread::task_thread_count(scene.processing.threads.value_or(0));
    return out;
}

/// What the file says of the map.
output::PictureInfo make_info(const MapArguments& args, const render::PictureRenderer& renderer,
                              const analyse::CellGrid& grid, const voxel::WorldInfo& world) {
    render::RenderStatistics known;
    known.counts.samples = static_cast<std::uint32_t>(renderer.view().scene.quality.samples);
    output::PictureInfo out = render::picture_info(renderer.view(), world, known, false);
    out.geo = analyse::make_placement(grid, world);
    const auto replace = [&](const std::string& name, const std::string& text) {
        if (text.empty())
            return;
        std::erase_if(out.metadata, [&](const auto& entry) { return entry.first == name; });
        out.metadata.emplace_back(name, text);
    };
    replace("ImageDescription", args.title);
    replace("Copyright", args.attribution);
    return out;
}

/// Metadata of map tiles. Web pages show an attribution as HTML, so that of the world, which comes
/// from untrusted data, is escaped.
pmtiles::MapTexts list_texts(const MapArguments& args, const voxel::WorldInfo& world,
                             const render::RenderStatistics& statistics) {
    return {args.title.empty() ? world.title : args.title,
            args.attribution.empty() ? util::escaped_markup(render::find_copyright(world))
                                     : args.attribution,
            statistics.counts.holes.size()};
}

/// Where the tiles lie, and of which zooms they are.
pmtiles::WebArea web_area(const MapArguments& args, const analyse::CellGrid& grid,
                          const voxel::WorldInfo& world) {
    constexpr int kUsual_px = 256;
    const std::string attempt = "write the map " + args.output + " of '" + world.title + "'";
    pmtiles::WebArea out =
        pmtiles::to_web_area(analyse::make_placement(grid, world), grid.columns, grid.rows,
                             args.tile_px > 0 ? args.tile_px : kUsual_px, attempt);
    if (args.zooms.empty())
        return out;
    const util::IntRange zooms = read_zooms(args);
    out.choose_zooms(zooms.first, zooms.last, attempt);
    return out;
}

util::ExitCode run_map(const MapArguments& args) {
    util::set_up_log(args.verbosity.quiet ? "error" : args.world.log_level);
    const auto start = std::chrono::steady_clock::now();
    scene::Scene scene = make_scene(args);
    MapFileOptions file = make_file(args, scene);
    // Reject what cannot be written before any work is done.
    check_map_target(file);
    if (!args.report.empty())
        util::check_writable(args.report);
    exports::Selection selection;
    selection.area = parse_area("map", args.grid);
    const render::RenderPoolOptions render_pool = args.render_pool.options(scene);

    const auto loaded = std::make_shared<render::LoadedWorld>(args.world.options(scene), scene);
    const voxel::WorldInfo& world = loaded->world->info();
    // A face has 16 x 16 points of its own colours.
    constexpr double kLeast_voxels = 1.0 / 16;
    const analyse::CellGrid grid = analyse::grid_over(
        world, exports::make_part(world, selection).bounds, args.grid.resolution_m, kLeast_voxels);
    analyse::set_camera(grid, world, scene);
    const output::StreamShape shape = make_shape(scene, grid);
    if (file.in_tiles())
        file.area = web_area(args, grid, world);

    const thread::StopSignals signals;
    file.is_stopped = [&] { return signals.token().stop_requested(); };
    render::PictureRenderer renderer(loaded, render_pool, scene, args.verbosity.quiet,
                                     signals.token());
    std::optional<MapFile> map;
    const auto begin = [&]() -> output::TileSink& {
        map.emplace(file, shape, make_info(args, renderer, grid, world));
        return map->sink();
    };
    std::uint64_t tiles = 0;
    const auto write = [&](const render::RenderStatistics& statistics) {
        const util::StageTimes::Scope timed(loaded->times, "write the map");
        tiles = map->write(list_texts(args, world, statistics));
    };
    const render::RenderStatistics statistics =
        renderer.render_tiles(scene, args.output, begin, write, {args.resume, true, {}}, start);
    if (!args.report.empty())
        util::write_file_atomically(
            args.report,
            render::make_report(statistics, loaded->times, renderer.view()).dump(2) + "\n");
    if (!args.verbosity.quiet) {
        if (args.verbosity.verbose || !args.report.empty())
            render::print_statistics(statistics, loaded->times);
        std::printf("wrote %s in %.1f s: %d x %d cells of %g m", args.output.c_str(),
                    statistics.seconds, grid.columns, grid.rows, grid.edge_m);
        if (file.in_tiles())
            std::printf(", %llu tiles of zooms %d to %d", static_cast<unsigned long long>(tiles),
                        file.area.min_zoom, file.area.max_zoom);
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
                     "(tiles of Web Mercator, EPSG:3857)")
        ->required();
    add_grid_arguments(*command, args->grid);
    command
        ->add_option("--tiles", args->tiles,
                     "of .pmtiles: webp (default), or png, which loses nothing")
        ->check(CLI::IsMember({"webp", "png"}));
    command->add_option(
        "--zooms", args->zooms,
        "of .pmtiles: zooms of the tiles, such as 8-14; default: from the one where "
        "the map has some 64 pixels to the one that has its resolution");
    command
        ->add_option("--tiles-px", args->tile_px,
                     "of .pmtiles: edge of a tile, 256 (default) or 512")
        ->check(CLI::IsMember({256, 512}));
    command->add_option("--title", args->title, "default: that of the world");
    command->add_option("--attribution", args->attribution,
                        "whose data it shows; of .pmtiles, HTML; default: that of the world");
    command->add_option("--report", args->report, "write times and counts to this file (JSON)");
    command->add_flag("--resume", args->resume,
                      "keep finished tiles in OUT.tiles until the map is finished, and go on with "
                      "those that are there");
    add_verbosity_flags(*command, args->verbosity);
    add_opening_arguments(
        *command, args->world,
        {"world", "generated", "processing", "sun", "sky", "quality", "output.exposure_ev",
         "output.adaptation", "output.tone", "output.credit"});
    add_render_pool_arguments(*command, args->render_pool);
    util::list_first(*command, {"--output", "--area", "--resolution", "--ortho", "--crs", "--voxel",
                                "--scene", "--date", "--sun-time-h", "--samples", "--zooms",
                                "--title", "--report", "--verbose", "--quiet"});
    return [args] { return run_map(*args); };
}

}  // namespace terravox::commands
