#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <stop_token>

#include "common/util/error.hpp"
#include "voxelserver/out/country/plan.hpp"

namespace CLI {
class App;
}

namespace terravox::commands {

/// Adds `country` with its commands.
/// @return runs the one that was given, once the arguments are parsed
[[nodiscard]] std::function<util::ExitCode()> add_country_command(CLI::App& app);

/// Adds `country plan`.
/// @return runs it once the arguments are parsed
[[nodiscard]] std::function<util::ExitCode()> add_country_plan(CLI::App& country);

/// Add `country run`, `country resume`, `country patch` and `country status`.
/// @return each runs its command once the arguments are parsed
[[nodiscard]] std::function<util::ExitCode()> add_country_run(CLI::App& country);
[[nodiscard]] std::function<util::ExitCode()> add_country_resume(CLI::App& country);
[[nodiscard]] std::function<util::ExitCode()> add_country_patch(CLI::App& country);
[[nodiscard]] std::function<util::ExitCode()> add_country_status(CLI::App& country);

struct RunnerOptions {
    int jobs = 0;     ///< tasks at the same time; 0: one for each core
    int threads = 0;  ///< of each task; 0: the cores divided by the tasks
    bool quiet = false;
};

/// Makes all shards of a plan that are not there, each as a process of its own: memory that a task
/// has held goes with it, and one that is killed, by whom or whatever, takes no other with it.
/// Shards that another process makes at the same time are waited for, and made here if that ends.
/// @throws Error when shards fail, or a stop is requested: tasks are ended then, and go on next
/// time
void make_all_shards(const country::PlanFolder& folder, const country::Plan& plan,
                     const RunnerOptions& options, const std::stop_token& stop);

}  // namespace terravox::commands
