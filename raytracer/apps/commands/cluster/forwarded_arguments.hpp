#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "raytracer/apps/commands/arguments/world_arguments.hpp"
#include "raytracer/core/scene/scene.hpp"

namespace terravox::cluster {

/// The words that begin a command line.
/// @param command "render", "animate", or the kind of an analysis
/// @return {"render"}, {"animate"} or {"analyse", KIND}
[[nodiscard]] std::vector<std::string> words_of_command(const std::string& command);

/// Arguments of `render`, `animate` or `analyse` that a job forwards. They are parsed by the same
/// commands that will parse them there: what those would reject is rejected before anything is
/// submitted.
struct ForwardedArguments {
    std::string command;             ///< as for words_of_command()
    std::vector<std::string> words;  ///< as given, without those removed by take()
    commands::WorldArguments world;
    std::vector<std::string> outputs;
    std::string animation;  ///< file; of `animate`
    std::string video;
    /// Options of `analyse`, with their values, for files that are made of the whole raster.
    std::vector<std::string> of_whole_raster;

    /// @throws UsageError as the command itself would
    [[nodiscard]] static ForwardedArguments read(const std::string& command,
                                                 const std::vector<std::string>& words);
    /// Whether they are those of an analysis.
    [[nodiscard]] bool is_analysis() const { return words_of_command(command).size() > 1; }
    /// Removes an option with its values from `words`.
    /// @param names such as {"-o", "--output"}
    void take(const std::vector<std::string>& names);
    /// Removes the options of `of_whole_raster` from `words`, and returns them.
    [[nodiscard]] std::vector<std::string> take_of_whole_raster();
    /// Whether an option is among `words`, as --name or --name=value.
    [[nodiscard]] bool has(const std::string& name) const;
    /// The scene without the fields that change from frame to frame.
    /// @throws UsageError
    [[nodiscard]] scene::Scene base_scene() const;
};

}  // namespace terravox::cluster
