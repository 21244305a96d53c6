#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <system_error>
#include <vector>

#include "common/util/atomic_file.hpp"
#include "common/util/command_line.hpp"
#include "common/util/error.hpp"
#include "common/util/log.hpp"
#include "common/util/text.hpp"
#include "raytracer/apps/commands/arguments/world_arguments.hpp"
#include "raytracer/apps/commands/commands.hpp"
#include "raytracer/apps/commands/run_arguments.hpp"
#include "raytracer/core/animate/video.hpp"
#include "raytracer/core/output/image_writer.hpp"
#include "raytracer/core/scene/scene_io.hpp"
#include "raytracer/core/scene/views.hpp"
#include "raytracer/farm/checkpoint/picture_key.hpp"
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
    scene::Scene scene = args.world.scene();
    args.world.choose_look(scene);
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

    render::PictureRenderer renderer(args.world.picture_options(scene), render_pool, scene,
                                     args.verbosity.quiet);
    const render::RenderStatistics statistics = renderer.render(scene, args.outputs, keep, start);
    if (!args.report.empty())
        util::write_file_atomically(
            args.report,
            render::make_report(statistics, renderer.times(), renderer.view()).dump(2) + "\n");
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
    allow_several(command->add_option("-o,--output", args->outputs,
                                      std::string("picture to write: ") + output::kPictureEndings +
                                          "; may be given several times"))
        ->required();
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

namespace {

struct AnimateArguments {
    WorldArguments world;
    RenderPoolArguments render_pool;
    animate::FrameOptions frames;
    std::string animation;
};

/// Identifies the inputs of finished frames. What the command reads besides its inputs, and what it
/// writes, may be in a folder of inputs and is none of them.
std::string names_of_inputs(const AnimateArguments& args, const scene::Scene& base) {
    const animate::FrameNames frames(args.frames.pattern);
    std::error_code ignored;
    std::set<std::filesystem::path> other_files;
    for (const std::string& file : {args.animation, args.frames.video})
        if (!file.empty())
            other_files.insert(std::filesystem::weakly_canonical(file, ignored));
    const std::vector<std::filesystem::path> orthophotos(args.world.orthophotos.begin(),
                                                         args.world.orthophotos.end());
    std::string out;
    for (const std::string& name : farm::name_inputs(
             args.world.inputs, orthophotos, base, [&](const std::filesystem::path& file) {
                 return other_files.contains(file) || frames.matches(file);
             }))
        out += name + "\n";
    return out;
}

util::ExitCode run_animate(const AnimateArguments& args, const OpenRenderer& open) {
    util::set_up_log(args.frames.quiet ? "error" : args.world.log_level);
    const animate::Animation animation = animate::Animation::read(args.animation);
    scene::Scene base =
        scene::compose_scene({scene::file_layer(args.world.scene_file),
                              [&](scene::Scene& scene) { animation.apply_base(scene); },
                              scene::fields_layer(args.world.fields)});
    // Keys of the animation may place the camera.
    scene::Scene first = animation.at(0, base);
    choose_plane(first);
    base.world.plane = first.world.plane;
    // Reject what cannot be written, or is inconsistent, before any work is done.
    const auto [width, height] = base.output.size_px;
    output::check_image_target(animate::FrameNames(args.frames.pattern).of(args.frames.first),
                               width, height);
    (void)animation.at(0, base);
    animate::FrameOptions frames = args.frames;
    frames.inputs = names_of_inputs(args, base);
    // The world is opened when the first frame has to be rendered: a finished film costs nothing.
    animate::RenderPicture render;
    return animate::render_frames(
        animation, base, frames,
        [&](const scene::Scene& scene, const std::filesystem::path& picture) {
            if (!render)
                render = open(args.world, args.render_pool, base, frames.quiet);
            return render(scene, picture);
        });
}

}  // namespace

std::function<util::ExitCode()> add_animate_command(CLI::App& app, OpenRenderer open) {
    auto args = std::make_shared<AnimateArguments>();
    CLI::App* command =
        app.add_subcommand("animate", "Render the frames of an animation, and a video of them");
    command
        ->add_option(
            "animation", args->animation,
            "what moves: a TOML file with keys, a turntable or a day (docs/formats/animation.md)")
        ->required();
    add_world_arguments(*command, args->world);
    add_render_pool_arguments(*command, args->render_pool);
    command
        ->add_option("-o,--output", args->frames.pattern,
                     "the frames' names, such as frames/%04d.png")
        ->required();
    command->add_option(
        "--video", args->frames.video,
        "make a video of the frames: .mp4, .mkv or .mov; through ffmpeg, which must be installed");
    command->add_option("--first", args->frames.first, "frame to begin with, from 0 on")
        ->capture_default_str();
    command->add_option("--last", args->frames.last, "last frame; default: the animation's");
    command->add_option("--every", args->frames.every, "only each n-th frame, for a look at it")
        ->capture_default_str();
    command->add_flag("--again", args->frames.again, "make frames once more that are done");
    command->add_flag("--list", args->frames.list,
                      "say which frames are still to be made, one number a line, and make none");
    command->add_flag("-q,--quiet", args->frames.quiet, "print errors only");
    util::list_first(*command,
                     {"--output", "--video", "--first", "--last", "--every", "--again", "--list",
                      "--ortho", "--crs", "--voxel", "--scene", "--size", "--samples", "--quiet"});
    return [args, open = std::move(open)] { return run_animate(*args, open); };
}

}  // namespace terravox::commands
