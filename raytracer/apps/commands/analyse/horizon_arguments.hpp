#pragma once

#include <string>

#include "common/voxel/world.hpp"
#include "raytracer/core/scene/scene.hpp"

namespace CLI {
class App;
}

namespace terravox::commands {

/// Terrain outside of the data, on a command line.
struct HorizonArguments {
    std::string file;  ///< raster of heights; empty: the horizon is free
    double range_km = 60;
};

void add_horizon_options(CLI::App& command, HorizonArguments& args);

/// @param scene of the analysis
/// @throws UsageError where rays end before the horizon
void check_horizon_arguments(const HorizonArguments& args, const scene::Scene& scene);

/// Puts the terrain into a scene, if there is any.
/// @throws as analyse::look_at_horizon()
void use_horizon(const HorizonArguments& args, const voxel::WorldInfo& world, scene::Scene& scene);

}  // namespace terravox::commands
