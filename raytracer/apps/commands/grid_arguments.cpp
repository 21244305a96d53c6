#include "raytracer/apps/commands/grid_arguments.hpp"

#include <CLI/CLI.hpp>

#include "raytracer/apps/commands/arguments/number_list.hpp"

namespace terravox::commands {

void add_grid_arguments(CLI::App& command, GridArguments& args) {
    command.add_option("--area", args.area,
                       "west,south,east,north in the world's CRS; x0,z0,x1,z1 in voxels where it "
                       "has none; default: all");
    command.add_option("--resolution", args.resolution_m,
                       "edge of a cell, metres; default: that of a voxel");
}

std::vector<double> area_of(const std::string& command, const GridArguments& args) {
    return numbers_of(command, "--area", args.area, 4,
                      "west,south,east,north, or x0,z0,x1,z1 in a world without a CRS");
}

}  // namespace terravox::commands
