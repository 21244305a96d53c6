#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <stop_token>
#include <string>
#include <vector>

#include "common/util/error.hpp"
#include "common/voxel/world.hpp"
#include "raytracer/core/scene/scene.hpp"
#include "voxelserver/make/worlds/kind/world_options.hpp"
#include "voxelserver/out/export/core/job.hpp"

namespace terravox::publish {

/// What a site is made of.
struct SiteOptions {
    worlds::WorldOptions world;  ///< what is published
    scene::Scene scene;          ///< what the viewer begins with
    /// The name of the conversion of a part of the world (exports::Job::name).
    std::function<std::string(const exports::Part& part, const voxel::World& world)> conversion;
    std::string title;  ///< empty: that of the world, as the two below
    std::string attribution;
    std::string licence;
    std::string area;                  ///< as it was given, for messages
    std::vector<double> area_numbers;  ///< west, south, east, north; none: all
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

/// Writes a site; one process at a time writes to a folder. All that may be refused is looked at
/// before anything is written.
/// @param folder of the site; made where it is missing. A folder with other files is refused,
/// unless they may be overwritten
/// @return kHoles: the site stands, but lacks what could not be read
/// @throws UsageError, Error
[[nodiscard]] util::ExitCode publish_site(const std::filesystem::path& folder,
                                          const SiteOptions& args);

}  // namespace terravox::publish
