#pragma once

#include <string>
#include <vector>

#include "raytracer/apps/commands/arguments/world_arguments.hpp"
#include "raytracer/core/scene/scene.hpp"
#include "raytracer/farm/cluster/slurm_run.hpp"

namespace terravox::cluster {

/// Arguments of `render`, `animate` or `analyse` that a job forwards. They are parsed by the same
/// commands that will parse them there: what those would reject is rejected before anything is
/// submitted.
struct ForwardedArguments : JobCommand {
    commands::WorldArguments world;
    /// Options of `analyse`, with their values, for files that are made of the whole raster.
    std::vector<std::string> of_whole_raster;

    /// @throws UsageError as the command itself would
    [[nodiscard]] static ForwardedArguments read(const std::string& command,
                                                 const std::vector<std::string>& words);
    /// Refuses options that the cluster gives itself.
    /// @param attempt beginning of the message
    /// @param allowed its end
    /// @throws UsageError
    void refuse(const std::vector<std::string>& names, const std::string& attempt,
                const std::string& allowed) const;
    /// Removes the options of `of_whole_raster` from `words`, and returns them.
    [[nodiscard]] std::vector<std::string> take_of_whole_raster();
    /// The scene without the fields that change from frame to frame.
    /// @throws UsageError
    [[nodiscard]] scene::Scene base_scene() const;
};

}  // namespace terravox::cluster
