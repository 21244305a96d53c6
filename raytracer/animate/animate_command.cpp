#include "raytracer/animate/animate_command.hpp"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <system_error>
#include <vector>

#include "common/util/log.hpp"
#include "raytracer/animate/frame_names.hpp"
#include "raytracer/material/material_file.hpp"
#include "raytracer/output/image_writer.hpp"
#include "raytracer/render/world_arguments.hpp"
#include "raytracer/scene/views.hpp"

namespace terravox {
namespace {

struct Arguments {
    WorldArguments world;
    FrameOptions frames;
    std::string animation;
};

/// What is shown, for the frames that are done: names and sizes of files, not their times, which change when a survey is copied to another machine.
/// @param points_only of a folder LiDAR files alone: the frames may lie in it, too
std::string contents_of(const std::string& input, bool points_only) {
    namespace fs = std::filesystem;
    std::vector<std::string> files;
    std::error_code failed;
    const auto note = [&](const fs::path& file) { files.push_back(file.string() + " " + std::to_string(fs::file_size(file, failed))); };
    if (fs::is_regular_file(input, failed)) note(input);
    for (fs::recursive_directory_iterator it(input, fs::directory_options::skip_permission_denied, failed), end; !failed && it != end; it.increment(failed)) {
        std::string ending = it->path().extension().string();
        std::transform(ending.begin(), ending.end(), ending.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
        const bool counts = points_only ? ending == ".las" || ending == ".laz" : !it->path().filename().string().starts_with('.');
        if (counts && fs::is_regular_file(it->path(), failed)) note(it->path());
    }
    std::sort(files.begin(), files.end());
    std::string out = input + "\n";
    for (const std::string& file : files) out += file + "\n";
    return out;
}

std::string text_of(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

ExitCode run(const Arguments& args, const OpenRenderer& open) {
    util::set_up_log(args.frames.quiet ? "error" : args.world.log_level);
    const Animation animation = Animation::read(args.animation);
    const Scene base = compose_scene({file_layer(args.world.scene_file), [&](Scene& scene) { animation.apply_base(scene); }, fields_layer(args.world.fields)});
    // Refuse what cannot be written, or does not fit together, before any work is done.
    check_image_target(FrameNames(args.frames.pattern).of(args.frames.first));
    (void)animation.at(0, base);
    FrameOptions frames = args.frames;
    for (const auto& input : args.world.inputs) frames.inputs += contents_of(input, true);
    for (const auto& photo : args.world.orthophotos) frames.inputs += "ortho " + contents_of(photo, false);
    frames.inputs += text_of(material::find_materials(base.quality.materials));
    // The world is opened when the first frame has to be made: a film that is done costs nothing.
    RenderPicture render;
    return render_frames(animation, base, frames, [&](const Scene& scene, const std::filesystem::path& picture) {
        if (!render) render = open(args.world, base, frames.quiet);
        return render(scene, picture);
    });
}

}  // namespace

std::function<ExitCode()> add_animate_command(CLI::App& app, OpenRenderer open) {
    auto args = std::make_shared<Arguments>();
    CLI::App* command = app.add_subcommand("animate", "Render the frames of an animation, and a video of them");
    command->add_option("animation", args->animation, "what moves: a TOML file with keys, a turntable or a day (docs/formats.md)")->required();
    add_world_arguments(*command, args->world);
    command->add_option("-o,--output", args->frames.pattern, "the frames' names, such as frames/%04d.png")->required();
    command->add_option("--video", args->frames.video, "make a video of the frames: .mp4, .mkv or .mov; through ffmpeg, which must be installed");
    command->add_option("--first", args->frames.first, "frame to begin with, from 0 on")->capture_default_str();
    command->add_option("--last", args->frames.last, "last frame; default: the animation's");
    command->add_option("--every", args->frames.every, "only each n-th frame, for a look at it")->capture_default_str();
    command->add_flag("--again", args->frames.again, "make frames once more that are done");
    command->add_flag("-q,--quiet", args->frames.quiet, "say nothing but errors");
    return [args, open = std::move(open)] { return run(*args, open); };
}

}  // namespace terravox
