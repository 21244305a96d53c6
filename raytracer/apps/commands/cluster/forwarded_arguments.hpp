#pragma once

#include <optional>
#include <string>
#include <vector>

#include "raytracer/apps/commands/arguments/world_arguments.hpp"
#include "raytracer/core/scene/scene.hpp"
#include "raytracer/farm/cluster/engines.hpp"

namespace terravox::cluster {

/// Arguments of `render`, `animate` or `analyse` that a job forwards. They are parsed by the same
/// commands that will parse them there: what those would reject is rejected before anything is
/// submitted.
struct ForwardedArguments {
    std::string command;  ///< "render", "animate", or the kind of an analysis
    Command words;        ///< as given, without those removed by take()
    std::vector<std::string> outputs;
    std::string animation;  ///< file; of `animate`
    std::string video;
    commands::WorldArguments world;

    /// @throws UsageError as the command itself would
    [[nodiscard]] static ForwardedArguments read(const std::string& command,
                                                 const std::vector<std::string>& words);
    /// The whole command line of a program.
    [[nodiscard]] Command with_program(const std::string& program) const;
    /// Removes options with their values from `words`.
    /// @param names such as {"-o", "--output"}
    /// @return what was removed
    Command take(const std::vector<std::string>& names);
    /// Whether an option is among `words`, as --name or --name=value.
    [[nodiscard]] bool has(const std::string& name) const;
    void add(const Command& more) { words.insert(words.end(), more.begin(), more.end()); }
    /// Adds the number of threads, unless the arguments give it, or their scene does, which is read
    /// where its files are those of this machine.
    /// @return the number that is given
    std::optional<int> add_threads(std::optional<int> threads, const Engine& engine);
    /// Refuses options that the cluster gives itself.
    /// @param allowed end of the message
    /// @throws UsageError
    void refuse(const std::vector<std::string>& names, const std::string& allowed) const;
    /// The scene without the fields that change from frame to frame.
    /// @throws UsageError
    [[nodiscard]] scene::Scene base_scene() const;
};

}  // namespace terravox::cluster
