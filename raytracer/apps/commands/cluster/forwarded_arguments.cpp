#include "raytracer/apps/commands/cluster/forwarded_arguments.hpp"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <functional>

#include "common/util/program.hpp"
#include "raytracer/apps/commands/analyse/analyse_run.hpp"
#include "raytracer/apps/commands/commands.hpp"
#include "raytracer/core/animate/animation.hpp"
#include "raytracer/core/scene/scene_io.hpp"
#include "raytracer/core/scene/views.hpp"

namespace terravox::cluster {
namespace {

/// The words that begin the command line: {"render"}, {"animate"} or {"analyse", KIND}.
Command begin_with(const std::string& command) {
    if (command == "render" || command == "animate")
        return {command};
    return {"analyse", command};
}

bool is_option(const std::string& word, const std::string& name) {
    return word == name || word.starts_with(name + "=") ||
           (name.size() == 2 && word.starts_with(name));
}

std::function<util::ExitCode()> add_command(CLI::App& app, const std::string& name) {
    if (name == "animate")
        return commands::add_animate_command(app, {});
    return name == "analyse" ? commands::add_analyse_command(app)
                             : commands::add_render_command(app);
}

std::vector<std::string> list_values(const CLI::App& command, const std::string& option) {
    const CLI::Option* found = command.get_option_no_throw(option);
    return found == nullptr ? std::vector<std::string>{} : found->results();
}

std::string find_value(const CLI::App& command, const std::string& option,
                       const std::string& otherwise = {}) {
    const auto values = list_values(command, option);
    return values.empty() ? otherwise : values.back();
}

}  // namespace

ForwardedArguments ForwardedArguments::read(const std::string& command,
                                            const std::vector<std::string>& words) {
    ForwardedArguments out;
    out.command = command;
    out.words = words;
    const Command beginning = begin_with(command);
    const std::string text =
        beginning.size() > 1 ? beginning.front() + " " + beginning.back() : command;
    if (words.empty() || words.front().starts_with('-'))
        throw util::UsageError(
            "cluster: " + (words.empty() ? "no world" : "unknown option " + words.front()) +
            "; allowed: options of the cluster, then the arguments of `terravox " + text +
            "`, which begin with the " + (command == "animate" ? "animation" : "world") +
            "; --help lists them");
    CLI::App app;
    const auto run = add_command(app, beginning.front());
    const Command line = out.with_program("terravox");
    std::vector<const char*> argv;
    for (const std::string& word : line)
        argv.push_back(word.c_str());
    if (util::parse_arguments(app, static_cast<int>(argv.size()), argv.data()))
        throw util::UsageError("cluster: --help among the arguments of `terravox " + text +
                               "`; allowed: before them");
    const CLI::App* found = &app;
    for (const std::string& word : beginning)
        found = found->get_subcommand(word);
    const CLI::App& parsed = *found;
    out.world.inputs = list_values(parsed, "inputs");
    out.world.orthophotos = list_values(parsed, "--ortho");
    out.world.scene_file = find_value(parsed, "--scene");
    out.world.cache = find_value(parsed, "--cache");
    out.world.log_level = find_value(parsed, "--log", out.world.log_level);
    for (const scene::SceneFlag& flag : scene::scene_flags())
        for (const std::string& name : {flag.names.substr(0, flag.names.find(',')), flag.former})
            if (!name.empty() && !list_values(parsed, name).empty())
                out.world.fields.emplace_back(flag.path, find_value(parsed, name));
    out.outputs = list_values(parsed, "--output");
    out.animation = find_value(parsed, "animation");
    out.video = find_value(parsed, "--video");
    return out;
}

Command ForwardedArguments::with_program(const std::string& program) const {
    return extend(extend({program}, begin_with(command)), words);
}

Command ForwardedArguments::take(const std::vector<std::string>& names) {
    Command taken;
    for (auto it = words.begin(); it != words.end();) {
        const auto name = std::find_if(names.begin(), names.end(),
                                       [&](const std::string& n) { return is_option(*it, n); });
        if (name == names.end()) {
            ++it;
            continue;
        }
        const auto end = std::min(words.end(), it + (*it == *name ? 2 : 1));
        taken.insert(taken.end(), it, end);
        it = words.erase(it, end);
    }
    return taken;
}

bool ForwardedArguments::has(const std::string& name) const {
    return std::any_of(words.begin(), words.end(),
                       [&](const std::string& word) { return is_option(word, name); });
}

std::optional<int> ForwardedArguments::add_threads(std::optional<int> threads,
                                                   const Engine& engine) {
    if (engine.runs_here) {
        if (const std::optional<int> given = base_scene().processing.threads)
            return given;
    }
    if (threads && !has("--threads"))
        add({"--threads", std::to_string(*threads)});
    return threads;
}

void ForwardedArguments::refuse(const std::vector<std::string>& names,
                                const std::string& allowed) const {
    for (const std::string& name : names)
        if (has(name))
            throw util::UsageError("cluster: " + name + " among the arguments of " + command +
                                   "; allowed: " + allowed);
}

scene::Scene ForwardedArguments::base_scene() const {
    std::vector<scene::SceneLayer> layers{scene::file_layer(world.scene_file)};
    if (!animation.empty())
        layers.push_back(
            [this](scene::Scene& scene) { animate::Animation::read(animation).apply_base(scene); });
    layers.push_back(scene::fields_layer(world.fields));
    return scene::compose_scene(layers);
}

}  // namespace terravox::cluster
