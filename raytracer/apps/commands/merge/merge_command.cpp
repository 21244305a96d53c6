#include "raytracer/apps/commands/merge/merge_command.hpp"

#include <fcntl.h>
#include <CLI/CLI.hpp>

#include <cstdio>
#include <memory>

#include "common/thread/parallel.hpp"
#include "common/util/log.hpp"
#include "common/util/printable.hpp"
#include "common/voxel/world_json.hpp"
#include "raytracer/apps/commands/merge/joined_raster.hpp"
#include "raytracer/apps/commands/run_report.hpp"
#include "raytracer/core/scene/scene_io.hpp"
#include "raytracer/farm/render/joined_pictures.hpp"

namespace terravox::commands {
namespace {

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

scene::Scene scene_of(const farm::PictureKey& key) {
    scene::Scene scene;
    scene::parse_scene(key.scene, "of the checkpoint", scene);
    return scene;
}

std::string what_is_made(const farm::PictureKey& key, const scene::Scene& scene) {
    if (scene.analysis.kind != core::AnalysisKind::kNone)
        return "cells of " + std::string(core::word_of(scene.analysis.kind));
    return "pixels, " + std::to_string(scene.quality.samples) + " samples" +
           (key.with_layers ? ", layers" : "");
}

/// Prints what one file belongs to, and how much of it is done. A coordinator may be writing to it
/// meanwhile.
void print_info(const std::filesystem::path& path) {
    const farm::TileJournal journal(farm::OpenFile(path, O_RDONLY, "read the checkpoint"));
    const farm::PictureKey& key = journal.key();
    const scene::Scene scene = scene_of(key);
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
    const scene::Scene scene = scene_of(tiles.key());
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
    command
        ->add_option("-o,--output", args->outputs,
                     "picture to write: .png .jpg (8-bit), .exr .tif (float); may be given several "
                     "times; of "
                     "an analysis: one .tif")
        ->expected(1)
        ->take_all()
        ->allow_extra_args(false);
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
