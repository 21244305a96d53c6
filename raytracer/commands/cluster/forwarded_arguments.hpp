#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "raytracer/commands/world_arguments.hpp"
#include "raytracer/scene/scene.hpp"

namespace terravox::cluster {

/// Arguments of `render` or `animate` that a job passes on, read by the very commands that will
/// read them there: what those would refuse is refused before anything is submitted.
struct ForwardedArguments {
    std::string command;             ///< "render" or "animate"
    std::vector<std::string> words;  ///< as they were given, but for what take() took
    commands::WorldArguments world;
    std::vector<std::string> outputs;
    std::string animation;  ///< file; of `animate`
    std::string video;

    /// @throws UsageError as the command itself would
    [[nodiscard]] static ForwardedArguments read(const std::string& command,
                                                 const std::vector<std::string>& words);
    /// Removes an option with its values from `words`. @param names such as {"-o", "--output"}
    void take(const std::vector<std::string>& names);
    [[nodiscard]] bool has(const std::string& name)
        const;  ///< whether an option stands among `words`, as --name or --name=value
    /// The scene without what changes from frame to frame. @throws UsageError
    [[nodiscard]] scene::Scene base_scene() const;
};

}  // namespace terravox::cluster
