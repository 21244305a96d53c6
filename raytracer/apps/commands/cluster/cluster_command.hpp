#pragma once

#include <functional>
#include <string>
#include <vector>

#include "common/util/error.hpp"
#include "raytracer/farm/cluster/slurm.hpp"

namespace terravox::cluster {

/// Renders one picture with workers that Slurm starts: run_pool() for the arguments `words`.
/// @return the picture's exit code
/// @throws Error, UsageError
[[nodiscard]] util::ExitCode run_slurm_pool(const SlurmOptions& options,
                                            const std::vector<std::string>& words);
/// Renders frames of an animation, or parts of a picture, as independent tasks: Batch for the
/// arguments `words`.
/// @throws Error, UsageError
[[nodiscard]] util::ExitCode run_slurm_batch(const SlurmOptions& options,
                                             const std::vector<std::string>& words);

/// Prepares LiDAR squares into the cache folder given by the arguments, so that later tasks need
/// not decode them.
/// @param command "render", "animate" or the kind of an analysis, whose arguments `words` are
/// @param part "I/N": the I-th square (counted from 1) and each N-th after it, in the order of
/// their paths
/// @return kHoles when some could not be decoded
/// @throws Error, UsageError
[[nodiscard]] util::ExitCode prepare_squares(const std::string& command, const std::string& part,
                                             const std::vector<std::string>& words);

}  // namespace terravox::cluster

namespace CLI {
class App;
}

namespace terravox::commands {

/// Adds `cluster` with its subcommands (slurm, openjd, kubernetes, bake) to the program's commands.
/// @return runs the subcommand that was given
/// @throws (when run) Error, UsageError
[[nodiscard]] std::function<util::ExitCode()> add_cluster_command(CLI::App& app);

}  // namespace terravox::commands
