#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/util/error.hpp"
#include "raytracer/core/scene/scene.hpp"
#include "raytracer/farm/render/render_pool.hpp"
#include "raytracer/farm/render/statistics.hpp"

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
[[nodiscard]] std::vector<double> parse_area(const std::string& command, const GridArguments& args);

/// Flags for the credentials of a program of the farm.
struct CredentialArguments {
    std::string token_file;
    std::string ca;
    std::string certificate;
    std::string key;

    /// The credentials given by flags or in the environment; nullopt: none.
    /// @throws UsageError, Error
    [[nodiscard]] std::optional<net::Credentials> find() const;
    /// @param listens if there is no token, one is made and printed on standard error, where `how`
    /// explains its use
    /// @throws UsageError, Error
    [[nodiscard]] net::Credentials credentials(bool listens, const std::string& how) const;
};
void add_credential_arguments(CLI::App& command, CredentialArguments& args);

/// Flags for what renders.
struct RenderPoolArguments {
    std::vector<std::string> workers;
    std::string listen;
    std::string give_up;
    bool green = false;
    CredentialArguments credentials;

    /// @throws UsageError, Error
    [[nodiscard]] render::RenderPoolOptions options(const scene::Scene& scene) const;
};
/// Adds the flags to a command. `args` must outlive the parsing.
void add_render_pool_arguments(CLI::App& command, RenderPoolArguments& args);

/// How much a command says while it runs and at its end. Only one of them is set.
struct Verbosity {
    bool quiet = false;    ///< errors only
    bool verbose = false;  ///< what the run cost, too
};

/// Adds the flags --quiet and --verbose to a command. `args` must outlive the parsing.
void add_verbosity_flags(CLI::App& command, Verbosity& args);

/// Tells what a picture or raster lacks: boxes, tiles, damaged parts of the data.
/// @param what it is, for messages: "picture"
/// @return kHoles where it lacks something, else kDone
[[nodiscard]] util::ExitCode report_gaps(const render::RenderStatistics& statistics,
                                         const std::string& what);

}  // namespace terravox::commands
