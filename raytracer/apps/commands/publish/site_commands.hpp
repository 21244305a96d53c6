#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <stop_token>
#include <string>
#include <vector>

#include "common/util/error.hpp"
#include "raytracer/apps/commands/arguments/world_arguments.hpp"

namespace terravox::commands {

/// What a site is made of.
struct PublishArguments {
    WorldArguments world;  ///< whose inputs are published
    std::string title;     ///< empty: that of the world, as the two below
    std::string attribution;
    std::string licence;
    std::string area;  ///< west,south,east,north; empty: all
    std::string
        archive_url;  ///< of the archive, which is not copied then; empty: it lies in the site
    std::uint64_t split_mib = 0;  ///< largest file; 0: no limit
    int memory_mib = 1024;
    bool no_preview = false;
    bool overwrite = false;  ///< the folder may hold other files
    bool quiet = false;
    /// Ends writing with an Error.
    std::stop_token stop;
    /// Called by the thread that requests the stop, while a world is being opened, which waits for
    /// nothing; nothing is being written then. Must not return. Empty: a stop waits.
    std::function<void()> abandon;
};

/// Sections of a scene that a site is made of.
[[nodiscard]] std::vector<std::string> site_sections();

/// Writes a site; one process at a time writes to a folder. All that may be refused is looked at
/// before anything is written.
/// @param folder of the site; made where it is missing. A folder with other files is refused,
/// unless they may be overwritten
/// @return kHoles: the site stands, but lacks what could not be read
/// @throws UsageError, Error
[[nodiscard]] util::ExitCode publish_site(const std::filesystem::path& folder,
                                          const PublishArguments& args);

}  // namespace terravox::commands

namespace CLI {
class App;
}

namespace terravox::commands {

/// Adds the options of `publish` to its program.
/// @return runs the command once the arguments are parsed
[[nodiscard]] std::function<util::ExitCode()> add_publish_options(CLI::App& app);

/// Adds the options of `view` to its program, which shows a site, or what it publishes for the time
/// that it runs, to a browser of this machine.
/// @return runs the command once the arguments are parsed
[[nodiscard]] std::function<util::ExitCode()> add_view_options(CLI::App& app);

}  // namespace terravox::commands
