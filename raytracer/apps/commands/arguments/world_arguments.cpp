#include "raytracer/apps/commands/arguments/world_arguments.hpp"

#include <algorithm>
#include <CLI/CLI.hpp>
#include <cmath>
#include <sstream>

#include "common/util/error.hpp"
#include "common/util/folders.hpp"
#include "common/util/log.hpp"
#include "common/util/numbers.hpp"
#include "raytracer/core/scene/scene_io.hpp"
#include "raytracer/core/scene/views.hpp"
#include "voxelserver/make/voxelize/points/settings.hpp"
#include "voxelserver/make/worlds/open/open_world.hpp"
#include "voxelserver/make/worlds/overlay/overlay_world.hpp"

namespace terravox::commands {

std::vector<double> list_numbers(const std::string& command, const std::string& flag,
                                 const std::string& text, std::size_t count,
                                 const std::string& allowed) {
    std::vector<double> out;
    std::istringstream in(text);
    for (std::string word; std::getline(in, word, ',');) {
        const auto value = util::parse_number<double>(word);
        if (!value || !std::isfinite(*value))
            break;
        out.push_back(*value);
    }
    if (!text.empty() &&
        (out.size() != count ||
         static_cast<std::size_t>(std::count(text.begin(), text.end(), ',')) + 1 != count))
        throw util::UsageError(command + ": " + flag + " " + text + "; allowed: " + allowed);
    return out;
}

CLI::Option* allow_several(CLI::Option* option) {
    return option->expected(1)->take_all()->allow_extra_args(false);
}

scene::Scene WorldArguments::scene() const {
    return scene::compose_scene({scene::file_layer(scene_file), scene::fields_layer(fields)});
}

worlds::WorldOptions WorldArguments::options(const scene::Scene& scene) const {
    worlds::WorldOptions out = scene::to_world_options(scene);
    out.inputs = inputs;
    out.orthophotos = orthophoto_paths();
    out.additions = additions;
    out.cache_dir = util::cache_dir(cache);
    return out;
}

worlds::WorldOptions WorldArguments::picture_options(const scene::Scene& scene) const {
    worlds::WorldOptions out = options(scene);
    out.plane = scene.world.plane;
    return out;
}

namespace {

/// Whether a camera shows a place from outside, as an eye would.
bool shows_from_outside(const scene::Scene::Camera& camera) {
    return !camera.position && camera.projection == core::CameraProjection::kPerspective;
}

}  // namespace

void choose_plane(scene::Scene& scene) {
    if (scene.world.plane.empty() && shows_from_outside(scene.camera))
        scene.world.plane = "table";
}

void WorldArguments::choose_look(scene::Scene& scene) const {
    if (!scene.world.plane.empty())
        return;
    choose_plane(scene);
    if (scene.world.plane.empty())
        return;
    // A value counts that the sun has anyway, too.
    std::vector<std::string> stated = scene::stated_fields(scene_file, scene.camera.look);
    for (const auto& [path, text] : fields)
        stated.push_back(path);
    if (std::any_of(stated.begin(), stated.end(),
                    [](const std::string& path) { return path.starts_with("sun."); }))
        return;
    // From the left, so low that shadows show the relief, and fall on the table next to the place.
    constexpr double kFromLeft_deg = 60;
    constexpr double kAltitude_deg = 32;
    scene.sun.azimuth_deg = std::remainder(scene.camera.azimuth_deg + kFromLeft_deg, 360);
    scene.sun.altitude_deg = kAltitude_deg;
}

namespace {

/// @param sections as for add_opening_arguments
bool is_flag(const std::string& path, const std::vector<std::string>& sections) {
    // Set by the name of the analysis.
    if (path == "analysis.kind")
        return false;
    const std::string section = path.substr(0, path.find('.'));
    if (sections.empty())
        return section != "analysis";
    if (path == "world.plane")  // of pictures
        return false;
    return std::any_of(sections.begin(), sections.end(), [&](const std::string& listed) {
        return listed == section || listed == path;
    });
}

}  // namespace

std::string world_inputs_help() {
    return worlds::allowed_inputs();
}

void add_world_arguments(CLI::App& command, WorldArguments& args) {
    command.add_option("inputs", args.inputs, world_inputs_help())->required();
    add_opening_arguments(command, args, {});
}

void add_opening_arguments(CLI::App& command, WorldArguments& args,
                           const std::vector<std::string>& sections) {
    allow_several(
        command.add_option("--ortho", args.orthophotos,
                           "orthophoto, or a folder of them; may be given several times"));
    allow_several(command.add_option(
        "--add", args.additions,
        std::string("planned object that is put into the world; may be given several "
                    "times: ") +
            overlay::kAdditionForms));
    command.add_option("--cache", args.cache,
                       "folder that keeps prepared LiDAR squares for the next run; none: nothing "
                       "on disk (default: ~/.cache/terravox)");
    command.footer(
        "A voxel server or web server that requires a token gets TERRAVOX_SERVER_TOKEN of the "
        "environment if TERRAVOX_SERVER_ORIGIN names it:\n"
        "http(s)://host[:port], over http this machine alone. No other server is sent it.\n\n" +
        voxelize::steps_help());
    command.add_option("--scene", args.scene_file, "scene file (TOML); flags override it");
    command.add_option("--log", args.log_level, "trace, debug, info, warn, error or off")
        ->capture_default_str();
    for (const scene::SceneFlag& flag : scene::scene_flags()) {
        if (!is_flag(flag.path, sections))
            continue;
        const std::string section = flag.path.substr(0, flag.path.find('.'));
        const auto keep = [&args, path = flag.path](const std::string& text) {
            // Here, since only the parser knows by which of its names the flag was typed.
            if (const std::string fault = scene::find_fault(path, text, scene::find_flag(path));
                !fault.empty())
                throw CLI::ValidationError(fault);
            args.fields.emplace_back(path, text);
        };
        command.add_option_function<std::string>(flag.names, keep, flag.help)
            ->type_name(flag.is_switch ? "yes|no" : "VALUE")
            ->group("Scene: " + section);
        if (flag.former.empty())
            continue;
        const auto keep_former = [keep, flag](const std::string& text) {
            util::log_warn("{} is called {} now; a later version will refuse the former name",
                           flag.former, flag.names);
            keep(text);
        };
        command.add_option_function<std::string>(flag.former, keep_former)->group("");
    }
}

}  // namespace terravox::commands
