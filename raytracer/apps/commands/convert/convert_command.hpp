#pragma once

#include <functional>
#include <string>

#include "common/util/error.hpp"
#include "common/voxel/world.hpp"
#include "raytracer/apps/commands/arguments/world_arguments.hpp"
#include "raytracer/core/scene/scene.hpp"
#include "voxelserver/out/export/core/job.hpp"

namespace CLI {
class App;
}

namespace terravox::commands {

/// The name of a conversion (exports::Job::name). Two conversions with the same settings that
/// affect their files have the same name: inputs and data files with size and time, part, options.
/// @param form the format, with its own options
[[nodiscard]] std::string job_name(const WorldArguments& arguments, scene::Scene scene,
                                   const exports::Part& part, const voxel::World& world,
                                   const std::string& form);

/// Adds the options of `convert` to its program.
/// @return runs the command once the arguments are parsed
[[nodiscard]] std::function<util::ExitCode()> add_convert_options(CLI::App& app);

}  // namespace terravox::commands
