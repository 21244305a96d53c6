#include "raytracer/apps/commands/country/country_command.hpp"

#include <CLI/CLI.hpp>

#include "raytracer/apps/commands/country/plan_command.hpp"
#include "raytracer/apps/commands/country/run_command.hpp"

namespace terravox::commands {

std::function<util::ExitCode()> add_country_command(CLI::App& app) {
    CLI::App* const group = app.add_subcommand(
        "country",
        "Make the box archive of a large area in shards, on this machine or on a cluster");
    group->require_subcommand(1);
    group->footer(
        "The archive is the one that `terravox convert` writes, byte for byte. Whatever is killed: "
        "the same command goes on, and nothing that is finished is made again.\n"
        "Exit code 3: done, but some places are missing; they are named.");
    const auto plan = add_country_plan(*group);
    const auto run = add_country_run(*group);
    const auto status = add_country_status(*group);
    const auto resume = add_country_resume(*group);
    const auto patch = add_country_patch(*group);
    return [=] {
        if (group->got_subcommand("plan"))
            return plan();
        if (group->got_subcommand("run"))
            return run();
        if (group->got_subcommand("patch"))
            return patch();
        return group->got_subcommand("status") ? status() : resume();
    };
}

}  // namespace terravox::commands
