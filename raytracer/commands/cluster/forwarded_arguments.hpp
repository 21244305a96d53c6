#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "raytracer/commands/world_arguments.hpp"
#include "raytracer/scene/scene.hpp"

namespace terravox::cluster {

/// Arguments of `render` or `animate` that a job forwards. They are parsed by the same commands
/// that will parse them there: what those would reject is rejected before anything is submitted.
struct ForwardedArguments {
    std::string command;             ///< "render" or "animate"
    std::vector<std::string> words;  ///< as given, without those removed by take()
    commands::WorldArguments world;
    std::vector<std::string> outputs;
    std::string animation;  ///< file; of `animate`
    std::string video;

    /// @throws UsageError as the command itself would
    [[nodiscard]] static ForwardedArguments read(const std::string& command,
                                                 const std::vector<std::string>& words);
    /// Removes an option with its values from `words`.
    /// @param names such as {"-o", "--output"}
    void take(const std::vector<std::string>& names);
    /// Whether an option is among `words`, as --name or --name=value.
    [[nodiscard]] bool has(const std::string& name) const;
    /// The scene without the fields that change from frame to frame.
    /// @throws UsageError
    [[nodiscard]] scene::Scene base_scene() const;
};

}  // namespace terravox::cluster
