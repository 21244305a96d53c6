#pragma once

#include <string>

#include "common/voxel/world.hpp"
#include "raytracer/apps/commands/arguments/world_arguments.hpp"
#include "raytracer/core/scene/scene.hpp"
#include "voxelserver/out/export/core/part.hpp"

namespace terravox::commands {

/// The name of a conversion (exports::Job::name). Two conversions with the same settings that
/// affect their files have the same name: inputs and data files with size and time, part, options.
/// @param form the format, with its own options
[[nodiscard]] std::string job_name(const WorldArguments& arguments, scene::Scene scene,
                                   const exports::Part& part, const voxel::World& world,
                                   const std::string& form);

}  // namespace terravox::commands
