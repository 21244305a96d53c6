#pragma once

#include <functional>
#include <string>
#include <vector>

#include "common/util/error.hpp"
#include "raytracer/farm/cluster/engines.hpp"

namespace terravox::cluster {

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

/// Options of jobs that sbatch submits.
void add_sbatch_options(CLI::App& command, cluster::Needs& needs);
/// Options of pods: --image, --claim, --mount.
void add_pod_options(CLI::App& command, cluster::PodPlace& pods);

/// Adds `cluster` with its subcommands (slurm, openjd, kubernetes, bake) to the program's commands.
/// @return runs the subcommand that was given
/// @throws (when run) Error, UsageError
[[nodiscard]] std::function<util::ExitCode()> add_cluster_command(CLI::App& app);

}  // namespace terravox::commands
