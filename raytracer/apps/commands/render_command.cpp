#include "raytracer/apps/commands/render_command.hpp"

#include <CLI/CLI.hpp>

#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "common/util/atomic_file.hpp"
#include "common/util/command_line.hpp"
#include "common/util/log.hpp"
#include "common/util/near_words.hpp"
#include "raytracer/apps/commands/arguments/world_arguments.hpp"
#include "raytracer/apps/commands/render_pool_arguments.hpp"
#include "raytracer/apps/commands/run_report.hpp"
#include "raytracer/core/output/image_writer.hpp"
#include "raytracer/core/scene/scene_io.hpp"
#include "raytracer/farm/render/picture_renderer.hpp"

namespace terravox::commands {
namespace {

struct RenderArguments {
    WorldArguments world;
    RenderPoolArguments render_pool;
    std::vector<std::string> outputs;
    std::string save_scene;
    std::string report;
    std::string part;
    Verbosity verbosity;
    bool resume = false;
};

util::ExitCode run_render(const RenderArguments& args) {
    util::set_up_log(args.verbosity.quiet ? "error" : args.world.log_level);
    const auto start = std::chrono::steady_clock::now();
    const scene::Scene scene = args.world.scene();
    // Reject what cannot be written before any work is done.
    if (args.outputs.empty())
        throw util::UsageError("render: no picture named; give -o FILE.png or FILE.exr");
    render::PictureRenderer::check(scene, args.outputs);
    render::KeepOptions keep{args.resume, true, {}};
    if (!args.part.empty() && !(keep.part = farm::Part::parse(args.part)))
        throw util::UsageError("render: --part " + args.part +
                               "; allowed: " + farm::Part::kAllowed);
    const render::RenderPoolOptions render_pool = args.render_pool.options(scene);
    if (!args.report.empty())
        util::check_writable(args.report);
    if (!args.save_scene.empty())
        util::write_file_atomically(args.save_scene, scene::to_toml(scene));

    render::PictureRenderer renderer(args.world.options(scene), render_pool, scene,
                                     args.verbosity.quiet);
    const render::RenderStatistics statistics = renderer.render(scene, args.outputs, keep, start);
    if (!args.report.empty())
        util::write_file_atomically(
            args.report,
            render::report_of(statistics, renderer.times(), renderer.view()).dump(2) + "\n");
    if (!args.verbosity.quiet) {
        if (args.verbosity.verbose || !args.report.empty())
            render::print_statistics(statistics, renderer.times());
        if (keep.part)
            std::printf("wrote %s in %.1f s: terravox merge makes a picture of all parts\n",
                        farm::checkpoint_path(args.outputs.front(), keep.part).c_str(),
                        statistics.seconds);
        else
            std::printf("wrote %s in %.1f s\n", util::comma_list(args.outputs).c_str(),
                        statistics.seconds);
    }
    return report_gaps(statistics, "picture");
}

}  // namespace

std::function<util::ExitCode()> add_render_command(CLI::App& app) {
    auto args = std::make_shared<RenderArguments>();
    CLI::App* command =
        app.add_subcommand("render", "Render a world to PNG, JPEG, EXR or TIFF files");
    command
        ->add_option(
            "-o,--output", args->outputs,
            "picture to write: .png .jpg (8-bit), .exr .tif (float); may be given several times")
        ->required()
        ->expected(1)
        ->take_all()
        ->allow_extra_args(false);
    add_world_arguments(*command, args->world);
    add_render_pool_arguments(*command, args->render_pool);
    command->add_option("--save-scene", args->save_scene,
                        "write the scene with all flags applied to this file");
    command->add_option("--report", args->report, "write times and counts to this file (JSON)");
    command->add_flag(
        "--resume", args->resume,
        "keep finished tiles in PICTURE.tiles until the picture is finished, and go on "
        "with those that are there");
    command->add_option("--part", args->part,
                        "I/N: only part I of N of the tiles, kept for terravox merge; no picture");
    add_verbosity_flags(*command, args->verbosity);
    util::list_first(*command, {"--output", "--ortho", "--crs", "--voxel", "--scene", "--look",
                                "--zoom", "--size", "--date", "--sun-time-h", "--samples",
                                "--denoise", "--report", "--verbose", "--quiet"});
    return [args] { return run_render(*args); };
}

}  // namespace terravox::commands
