#include "raytracer/apps/commands/publish/publish_command.hpp"

#include <CLI/CLI.hpp>

#include <cstdio>
#include <filesystem>
#include <memory>

#include "common/util/log.hpp"
#include "raytracer/apps/commands/publish/publish_site.hpp"
#include "voxelserver/make/worlds/open/world_kinds.hpp"

namespace terravox::commands {
namespace {

namespace fs = std::filesystem;

struct CommandArguments {
    PublishArguments publish;
    std::vector<std::string> paths;
};

util::ExitCode run_publish(CommandArguments& args) {
    auto& [publish, paths] = args;
    util::set_up_log(publish.quiet ? "error" : publish.world.log_level);
    if (paths.back().empty())
        throw util::UsageError("publish: the site's folder has an empty name");
    if (paths.size() < 2)
        throw util::UsageError("publish: " + std::to_string(paths.size()) +
                               " path; allowed: what to publish, then the folder of the site");
    const fs::path folder = fs::path(paths.back()) / "";
    publish.world.inputs.assign(paths.begin(), paths.end() - 1);
    const util::ExitCode code = publish_site(folder, publish);
    if (!publish.quiet)
        std::printf(
            "wrote %s: terravox view shows it here, and any web server that answers range "
            "requests shows it to others\n",
            (folder / "index.html").c_str());
    return code;
}

}  // namespace

std::function<util::ExitCode()> add_publish_options(CLI::App& app) {
    auto args = std::make_shared<CommandArguments>();
    PublishArguments& publish = args->publish;
    app.add_option("paths", args->paths,
                   "what to publish: " + worlds::allowed_inputs() + "; then the site's folder")
        ->required();
    app.add_option("--title", publish.title, "of the site; default: that of the world");
    app.add_option("--attribution", publish.attribution,
                   "who the data come from; default: that of the world");
    app.add_option("--licence", publish.licence, "of the data; default: that of the world");
    app.add_option(
        "--area", publish.area,
        "west,south,east,north in the world's CRS; x0,z0,x1,z1 in voxels where it has none; "
        "default: all, or what a picture of an endless world shows");
    CLI::Option* address = app.add_option(
        "--archive-url", publish.archive_url,
        "where the archive lies, which is not copied then: https://..., or an address relative to "
        "the page");
    app.add_option("--split-mib", publish.split_mib,
                   "largest file that the host takes, MiB: larger archives are cut into parts; 0: "
                   "no limit")
        ->check(CLI::Range(0, 1 << 20))
        ->capture_default_str()
        ->excludes(address);
    app.add_option("--write-memory-mib", publish.memory_mib,
                   "memory for writing, in addition to the world's own limit, MiB")
        ->check(CLI::Range(64, 1 << 20))
        ->capture_default_str();
    app.add_flag("--no-preview", publish.no_preview,
                 "without the picture that links are shown with");
    app.add_flag("--overwrite", publish.overwrite,
                 "also into a folder that holds other files, of which some may be replaced");
    app.add_flag("-q,--quiet", publish.quiet, "print errors only");
    add_opening_arguments(app, publish.world, site_sections());
    return [args] { return run_publish(*args); };
}

}  // namespace terravox::commands
