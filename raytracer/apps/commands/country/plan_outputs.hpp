#pragma once

#include <string>

#include "raytracer/farm/cluster/engines.hpp"
#include "voxelserver/out/country/plan.hpp"

namespace CLI {
class App;
}

namespace terravox::commands {

/// A plan in lines for people, without its missing squares.
[[nodiscard]] std::string to_text(const country::Plan& plan);
/// What it foresees as a JSON object, with its missing squares.
/// @param folder of the plan
[[nodiscard]] std::string to_json(const country::Plan& plan, const std::string& folder);

/// Options of `country plan` for the tasks of schedulers.
struct ScriptArguments {
    std::string slurm;  ///< files to write; empty: none
    std::string kubernetes;
    std::string openjd;
    std::string archive;  ///< empty: the plan's name with .tvx
    std::string program;
    std::string name = "country";
    cluster::Place place{.needs = {.cpus = 1}};

    void add_to(CLI::App& command);
    /// @throws UsageError, before anything is planned
    void check() const;
    /// Writes the files.
    /// @param given the folder of the plan as the user named it
    /// @throws Error
    void write(const country::PlanFolder& folder, const country::Plan& plan,
               const std::string& given) const;
};

}  // namespace terravox::commands
