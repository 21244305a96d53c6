#include <fcntl.h>
#include <array>
#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/thread/parallel.hpp"
#include "common/thread/stop.hpp"
#include "common/util/log.hpp"
#include "common/util/text.hpp"
#include "common/voxel/world.hpp"
#include "raytracer/analyse/raster/cell_file.hpp"
#include "raytracer/apps/commands/analyse/object_arguments.hpp"
#include "raytracer/apps/commands/analyse/raster_outputs.hpp"
#include "raytracer/apps/commands/arguments/world_arguments.hpp"
#include "raytracer/apps/commands/commands.hpp"
#include "raytracer/apps/commands/run_arguments.hpp"
#include "raytracer/core/output/image_writer.hpp"
#include "raytracer/core/scene/scene.hpp"
#include "raytracer/core/scene/scene_io.hpp"
#include "raytracer/farm/checkpoint/tile_journal.hpp"
#include "raytracer/farm/render/joined_pictures.hpp"

namespace terravox::commands {
namespace {

using core::AnalysisKind;

/// What `merge` makes of an analysis in addition to its raster, as `analyse` does.
struct JoinedRasterArguments {
    ReportArguments reports;
    ObjectArguments objects;
    bool as_json = false;
};

/// The options of merge that some analyses have, and which those are.
struct OwnOption {
    const char* name;
    bool is_given;
    std::optional<AnalysisKind> of;  ///< nullopt: all
};

std::array<OwnOption, 5> own_options(const JoinedRasterArguments& args) {
    return {{{"--report", !args.reports.page.empty(), std::nullopt},
             {"--map", !args.reports.map.empty(), std::nullopt},
             {"--objects", !args.objects.file.empty(), AnalysisKind::kEnergy},
             {"--polygons", !args.objects.polygons.empty(), AnalysisKind::kEnergy},
             {"--json", args.as_json, AnalysisKind::kSight}}};
}

/// Planned objects are a part of what the world's boxes come from.
std::vector<std::string> list_additions(const farm::PictureKey& key) {
    constexpr std::string_view kState = "state of the archive: ";
    std::vector<std::string> out;
    for (const std::string& input : key.inputs)
        if (input.starts_with(kState))
            out.push_back(input.substr(kState.size()));
    return out;
}

void add_joined_raster_options(CLI::App& command, JoinedRasterArguments& args) {
    add_report_options(command, args.reports);
    add_object_options(command, args.objects);
    command.add_flag("--json", args.as_json,
                     "of sight: print what is seen, by material and class, as one JSON object");
    for (const OwnOption& option : own_options(args))
        command.get_option(option.name)->group("Rasters of analyses");
}

/// Refuses options that only rasters have.
void check_is_no_raster(const JoinedRasterArguments& args) {
    for (const OwnOption& option : own_options(args))
        if (option.is_given)
            throw util::UsageError(std::string("merge: ") + option.name +
                                   " with parts of a picture; allowed: with parts of an analysis");
}

/// Checks, before anything is written, that the raster can be.
/// @param scene of the checkpoint, with an analysis
void check_joined_raster(const scene::Scene& scene, const std::vector<std::string>& outputs,
                         const JoinedRasterArguments& args) {
    const AnalysisKind kind = scene.analysis.kind;
    for (const OwnOption& option : own_options(args))
        if (option.is_given && option.of && *option.of != kind)
            throw util::UsageError(std::string("merge: ") + option.name +
                                   " with parts of an analysis of " +
                                   std::string(core::to_word(kind)) + "; allowed: of " +
                                   std::string(core::to_word(*option.of)));
    if (outputs.size() != 1)
        throw util::UsageError("merge: " + std::to_string(outputs.size()) +
                               " files for the raster of an analysis; allowed: 1, -o FILE.tif");
    analyse::check_raster_target(outputs.front());
    check_report_targets(args.reports);
    (void)make_relief(scene);
    if (kind == AnalysisKind::kEnergy)
        check_object_arguments(args.objects, scene, false);
}

/// Writes the files that `analyse` would have written without --part: the same bytes.
/// @param tiles must be complete
/// @return kHoles where boxes could not be read
util::ExitCode write_joined_raster(const farm::JoinedTiles& tiles, const scene::Scene& scene,
                                   const std::string& output, const JoinedRasterArguments& args,
                                   int threads, bool quiet) {
    const farm::PictureKey& key = tiles.key();
    const voxel::WorldInfo world = voxel::world_from_json(key.world, "the checkpoint");
    const analyse::CellGrid grid = analyse::make_grid(scene, world);
    const thread::StopSignals signals;
    render::RenderStatistics statistics;
    statistics.damage = tiles.damage();
    statistics.counts.samples = static_cast<std::uint32_t>(scene.quality.samples);
    std::optional<PlannedObjects> objects;
    if (!args.objects.file.empty())
        objects.emplace(args.objects, scene, grid, world);
    analyse::CellFile cells(output, scene.analysis.kind, grid.columns, grid.rows, key.grid.tile_px);
    tiles.each([&](tiles::TileResult&& tile) {
        if (signals.token().stop_requested())
            throw util::Error(cells.attempt() + ": interrupted");
        cells.add(tile);
        statistics.counts.add(tile);
    });
    const Reported what{world,
                        scene,
                        grid,
                        list_additions(key),
                        scene.analysis.light.empty() ? "" : "a weather file",
                        statistics.counts.holes.size()};
    const auto seen = write_outputs(cells, {output, args.reports, objects}, what,
                                    render::joined_picture_info(scene, world, statistics), threads,
                                    signals.token());
    if (seen && args.as_json)
        std::printf("%s\n", analyse::to_json(*seen).c_str());
    else if (seen && !quiet)
        std::printf("%s", analyse::make_table(*seen).c_str());
    if (!quiet && !args.as_json)
        for (const std::string& file :
             {output, args.objects.file, args.reports.map, args.reports.page})
            if (!file.empty())
                std::printf("wrote %s\n", file.c_str());
    return report_gaps(statistics, "raster");
}

struct MergeArguments {
    std::vector<std::filesystem::path> journals;
    std::vector<std::string> outputs;
    std::string tiles;
    render::PictureOptions picture;
    JoinedRasterArguments raster;
    std::string log_level = "info";
    bool info = false;
    bool quiet = false;
};

scene::Scene make_scene(const farm::PictureKey& key) {
    scene::Scene scene;
    scene::parse_scene(key.scene, "of the checkpoint", scene);
    return scene;
}

std::string what_is_made(const farm::PictureKey& key, const scene::Scene& scene) {
    if (scene.analysis.kind != core::AnalysisKind::kNone)
        return "cells of " + std::string(core::to_word(scene.analysis.kind));
    return "pixels, " + std::to_string(scene.quality.samples) + " samples" +
           (key.with_layers ? ", layers" : "");
}

/// Prints what one file belongs to, and how much of it is done. A coordinator may be writing to it
/// meanwhile.
void print_info(const std::filesystem::path& path) {
    const farm::TileJournal journal(farm::OpenFile(path, O_RDONLY, "read the checkpoint"));
    const farm::PictureKey& key = journal.key();
    const scene::Scene scene = make_scene(key);
    std::uint32_t holes = 0;
    for (std::uint32_t cell = 0; cell < key.grid.cells(); ++cell)
        holes += journal.at(cell).holes > 0 ? 1 : 0;
    std::printf("%s: %llu bytes\n", util::printable(path.string()).c_str(),
                static_cast<unsigned long long>(journal.end()));
    std::printf("  of       %s, %dx%d %s\n",
                util::printable(voxel::world_from_json(key.world, path.string()).title).c_str(),
                key.grid.width_px, key.grid.height_px, what_is_made(key, scene).c_str());
    std::printf("  made by  %s, build %s\n", util::printable(key.software).c_str(),
                util::printable(key.build).c_str());
    for (const std::string& input : key.inputs)
        std::printf("  from     %s\n", util::printable(input).c_str());
    std::printf("  done     %u of %u tiles of %d pixels (%.1f %%)", journal.count(),
                key.grid.cells(), key.grid.tile_px, 100.0 * journal.count() / key.grid.cells());
    if (holes > 0)
        std::printf(", %u of them with holes", holes);
    std::printf("\n");
    if (journal.count() < key.grid.cells())
        std::printf("  missing  in rows %s of %u\n",
                    farm::rows_missing(
                        key.grid, [&](std::uint32_t cell) { return journal.at(cell).is_there(); })
                        .c_str(),
                    key.grid.rows());
    for (const std::string& line : journal.damage())
        std::printf("  damage   %s\n", util::printable(line).c_str());
    if (const std::string damaged = journal.what_is_damaged(); !damaged.empty())
        std::printf("  %s\n", util::printable(damaged).c_str());
}

void check(const MergeArguments& args) {
    if (args.info && (!args.outputs.empty() || !args.tiles.empty()))
        throw util::UsageError("merge: --info with -o or --tiles; allowed: --info alone");
    if (!args.info && args.outputs.empty() && args.tiles.empty())
        throw util::UsageError(
            "merge: nothing to write named; give -o FILE.exr, --tiles FILE.tiles, or --info");
}

void check_outputs(const MergeArguments& args, const farm::PictureKey& key,
                   const scene::Scene& scene) {
    if (scene.analysis.kind != core::AnalysisKind::kNone)
        return check_joined_raster(scene, args.outputs, args.raster);
    check_is_no_raster(args.raster);
    render::check_joined_pictures(key, args.outputs, args.picture);
}

util::ExitCode run_merge(MergeArguments& args) {
    util::set_up_log(args.quiet ? "error" : args.log_level);
    check(args);
    if (args.info) {
        for (const auto& journal : args.journals)
            print_info(journal);
        return util::ExitCode::kDone;
    }
    args.picture.threads = thread::thread_count(args.picture.threads);
    const farm::JoinedTiles tiles(args.journals);
    const scene::Scene scene = make_scene(tiles.key());
    const bool is_raster = scene.analysis.kind != core::AnalysisKind::kNone;
    if (!args.outputs.empty())
        check_outputs(args, tiles.key(), scene);
    if (!args.tiles.empty()) {
        tiles.write(args.tiles);
        if (!args.quiet)
            std::printf("wrote %s: %u of %u tiles\n", args.tiles.c_str(), tiles.count(),
                        tiles.key().grid.cells());
    }
    if (args.outputs.empty())
        return util::ExitCode::kDone;
    if (tiles.missing() > 0)
        throw util::Error(
            "merge into " + args.outputs.front() + ": " + std::to_string(tiles.missing()) + " of " +
            std::to_string(tiles.key().grid.cells()) + " tiles are missing, in rows " +
            tiles.rows_missing() + " of " + std::to_string(tiles.key().grid.rows()));
    if (is_raster)
        return write_joined_raster(tiles, scene, args.outputs.front(), args.raster,
                                   args.picture.threads, args.quiet);
    const render::RenderStatistics s =
        render::write_joined_pictures(tiles, args.outputs, args.picture);
    if (!args.quiet)
        for (const std::string& output : args.outputs)
            std::printf("wrote %s\n", output.c_str());
    return report_gaps(s, "picture");
}

}  // namespace

std::function<util::ExitCode()> add_merge_command(CLI::App& app) {
    auto args = std::make_shared<MergeArguments>();
    CLI::App* command = app.add_subcommand(
        "merge",
        "Join the checkpoints of several coordinators of one picture or analysis, and write it");
    command
        ->add_option("checkpoints", args->journals,
                     "files that render or analyse has written with --resume or --part: "
                     "PICTURE.tiles")
        ->required();
    allow_several(
        command->add_option("-o,--output", args->outputs,
                            std::string("picture to write: ") + output::kPictureEndings +
                                "; may be given several times; of an analysis: one .tif"));
    command->add_option("--tiles", args->tiles,
                        "write all tiles that are there to this file, a checkpoint of its own");
    command->add_flag("--info", args->info,
                      "say of each file which picture it is of and how much of it is done");
    command
        ->add_option("--memory-mib", args->picture.memory_mib,
                     "a picture that would take more than half of it goes tile by tile into its "
                     "files (1 to 1048576)")
        ->check(CLI::Range(1, 1 << 20))
        ->capture_default_str();
    command
        ->add_option("--threads", args->picture.threads,
                     "for noise and for files; 0: one for each core (0 to 1024)")
        ->check(CLI::Range(0, 1024))
        ->default_val(0);
    add_joined_raster_options(*command, args->raster);
    command->add_option("--log", args->log_level, "trace, debug, info, warn, error or off")
        ->capture_default_str();
    command->add_flag("-q,--quiet", args->quiet, "print errors only");
    return [args] { return run_merge(*args); };
}

}  // namespace terravox::commands
