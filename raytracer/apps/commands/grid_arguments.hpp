#pragma once

#include <optional>
#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace terravox::commands {

/// The part of a world that a raster covers, and its cells.
struct GridArguments {
    std::string area;
    std::optional<double> resolution_m;  ///< nullopt: a voxel
};

/// Adds the flags to a command. `args` must outlive the parsing.
void add_grid_arguments(CLI::App& command, GridArguments& args);

/// The numbers of --area.
/// @param command for messages
/// @return west, south, east, north in the world's CRS, or x0, z0, x1, z1; empty: all
/// @throws UsageError
[[nodiscard]] std::vector<double> area_of(const std::string& command, const GridArguments& args);

}  // namespace terravox::commands
