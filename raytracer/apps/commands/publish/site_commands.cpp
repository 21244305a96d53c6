#include "raytracer/apps/commands/publish/site_commands.hpp"

#include <chrono>
#include <CLI/CLI.hpp>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <stop_token>
#include <string>

#include "common/thread/stop.hpp"
#include "common/util/folders.hpp"
#include "common/util/log.hpp"
#include "common/util/process.hpp"
#include "raytracer/apps/commands/arguments/world_arguments.hpp"
#include "raytracer/apps/commands/convert/convert_command.hpp"
#include "raytracer/apps/publish/publish_site.hpp"
#include "raytracer/apps/publish/site.hpp"
#include "raytracer/apps/publish/site_host.hpp"
#include "voxelserver/make/worlds/open/open_world.hpp"

namespace terravox::commands {
namespace {

namespace fs = std::filesystem;

/// Sections of a scene that a site is made of.
const std::vector<std::string> kSections = {"world", "generated", "processing", "camera",
                                            "sun",   "sky",       "quality",    "output"};

struct PublishArguments : publish::SiteOptions {
    WorldArguments arguments;  ///< of the world and the scene
};

util::ExitCode publish_site(const fs::path& folder, PublishArguments& args) {
    args.scene = args.arguments.scene();
    args.world = args.arguments.options(args.scene);
    args.area_numbers =
        list_numbers("publish", "--area", args.area, 4,
                     "west,south,east,north, or x0,z0,x1,z1 in a world without a CRS");
    args.conversion = [&args](const exports::Part& part, const voxel::World& world) {
        return job_name(args.arguments, args.scene, part, world, "archive true");
    };
    return publish::publish_site(folder, args);
}

struct CommandArguments {
    PublishArguments publish;
    std::vector<std::string> paths;
};

util::ExitCode run_publish(CommandArguments& args) {
    auto& [publish, paths] = args;
    util::set_up_log(publish.quiet ? "error" : publish.arguments.log_level);
    if (paths.back().empty())
        throw util::UsageError("publish: the site's folder has an empty name");
    if (paths.size() < 2)
        throw util::UsageError("publish: " + std::to_string(paths.size()) +
                               " path; allowed: what to publish, then the folder of the site");
    const fs::path folder = fs::path(paths.back()) / "";
    publish.arguments.inputs.assign(paths.begin(), paths.end() - 1);
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
    add_opening_arguments(app, publish.arguments, kSections);
    return [args] { return run_publish(*args); };
}

namespace {

struct ViewArguments {
    PublishArguments publish;
    std::vector<std::string> paths;
    int port = 0;
    bool no_browser = false;
    bool allow_archive_host = false;
};

constexpr const char* kStopped = "view: stopped before the place was published";

/// Publishes into a new folder.
/// @throws Error, also when stopped
util::ExitCode publish_into(util::TemporaryFolder& scratch, PublishArguments& publish,
                            const std::stop_token& stop) {
    scratch = util::TemporaryFolder::make("view");
    publish.no_preview = true;
    publish.stop = stop;
    // Opening a world does not wait for a stop, so the program ends.
    publish.abandon = [&scratch] {
        scratch.remove();
        std::fprintf(stderr, "terravox: %s\n", kStopped);
        std::_Exit(static_cast<int>(util::ExitCode::kFailed));
    };
    try {
        const util::ExitCode code = publish_site(scratch.path(), publish);
        if (!stop.stop_requested())
            return code;
    } catch (const util::Error&) {
        if (!stop.stop_requested())
            throw;
    }
    throw util::Error(kStopped);
}

// Where there is a desktop; elsewhere the address has been printed.
void open_browser(const std::string& address) {
    if (std::getenv("DISPLAY") == nullptr && std::getenv("WAYLAND_DISPLAY") == nullptr)
        return;
    try {
        util::Process({.command = {"xdg-open", address}, .may_outlive = true}).detach();
    } catch (const util::Error&) {
        util::log_info("view: xdg-open is missing; open {} yourself", address);
    }
}

/// The origin that the page of a site may ask for its archive; empty: none.
std::string archive_origin(const fs::path& site, bool is_allowed) {
    const auto found = publish::read_site(site);
    std::string origin = found ? publish::to_origin(found->archive_url) : std::string();
    if (origin.empty() || is_allowed)
        return origin;
    util::log_warn(
        "view: the archive of this site lies at {}, which its page may not ask; "
        "--allow-archive-host permits it",
        origin);
    return {};
}

util::ExitCode run_view(ViewArguments& args) {
    PublishArguments& publish = args.publish;
    util::set_up_log(publish.quiet ? "error" : publish.arguments.log_level);
    util::TemporaryFolder scratch;
    fs::path site = args.paths.front();
    util::ExitCode code = util::ExitCode::kDone;
    const thread::StopSignals signals;
    if (args.paths.size() > 1 || !fs::exists(site / "place.json")) {
        publish.arguments.inputs = args.paths;
        code = publish_into(scratch, publish, signals.token());
        site = scratch.path();
    }
    const publish::SiteHost host(site, static_cast<std::uint16_t>(args.port),
                                 archive_origin(site, args.allow_archive_host));
    std::printf("%s  (Ctrl-C ends)\n", host.address().c_str());
    std::fflush(stdout);
    if (!args.no_browser)
        open_browser(host.address());
    while (!thread::wait_for_stop(signals.token(), std::chrono::hours(1))) {
    }
    return code;
}

}  // namespace

std::function<util::ExitCode()> add_view_options(CLI::App& app) {
    auto args = std::make_shared<ViewArguments>();
    app.add_option("paths", args->paths,
                   "a site of terravox publish, or what to look at: " + worlds::allowed_inputs())
        ->required();
    app.add_option("--port", args->port, "of this machine; 0: any that is free")
        ->check(CLI::Range(0, 65535))
        ->capture_default_str();
    app.add_flag("--allow-archive-host", args->allow_archive_host,
                 "the page may ask the host that the site names for its archive; otherwise it asks "
                 "nobody but this program");
    app.add_flag("--no-browser", args->no_browser, "print the address only");
    app.add_flag("-q,--quiet", args->publish.quiet, "print the address and errors only");
    add_opening_arguments(app, args->publish.arguments, kSections);
    return [args] { return run_view(*args); };
}

}  // namespace terravox::commands
