#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "common/util/error.hpp"
#include "voxelserver/make/worlds/kind/served_world.hpp"
#include "voxelserver/make/worlds/kind/world_options.hpp"
#include "voxelserver/serve/boxes/box_cache.hpp"
#include "voxelserver/serve/boxes/preparer.hpp"
#include "voxelserver/serve/host/host.hpp"
#include "voxelserver/serve/host/host_names.hpp"
#include "voxelserver/serve/http/request_check.hpp"
#include "voxelserver/serve/jobs/job_queue.hpp"

namespace CLI {
class App;
}

namespace terravox::serve {

/// The command line of terravox-voxelserver.
struct Options {
    worlds::WorldOptions world;
    /// Flags given by the user that are valid for some kinds of worlds only.
    std::vector<std::string> kind_flags;
    http::HostOptions server;
    /// Accepted host names in addition to those of http::HostNames.
    std::vector<std::string> public_names;
    std::vector<std::string> shared_origins;  ///< of pages that may read an archive; see Plan
    std::filesystem::path store;  ///< folder filled by the grabber; empty: the inputs are named
    int memory_mib = 2048;        ///< limit for the whole process
    /// Limit of the cache folder: half for prepared squares, half for finished boxes.
    std::int64_t cache_mib = 40960;
    int box_timeout_s = 30;  ///< timeout for fetching a box from another server
    int queue = 96;          ///< boxes that may wait to be made
    /// 0 = automatic: as many as can make or wait for boxes, and some for other requests.
    int request_threads = 0;
    double header_timeout_s = 5;
    double keep_alive_s = 2;
    double drain_s = 10;
    int jobs = 0;  ///< analyses at the same time; 0: none
    jobs::JobLimits job_limits;
    bool no_ahead = false;
    bool prepare = false;
    bool prepare_only = false;
    std::string cache;  ///< as util::cache_dir
    /// "": the credential of the service, else TERRAVOX_SERVER_TOKEN of the environment, else none
    std::string token_file;
    std::string log_level = "info";
    bool log_json = false;
};

/// Declares the flags; they are stored into `options` when the app parses.
void add_options(CLI::App& app, Options& options);

/// Settings derived from the flags.
struct Plan {
    boxes::BoxCacheOptions boxes;
    std::uint64_t square_bytes = 0;  ///< disk limit for prepared LiDAR squares
    std::size_t map_bytes = 0;       ///< memory limit for the map
    std::size_t image_bytes = 0;     ///< memory limit for decoded images
    std::string token;               ///< "" = none
    http::HostNames names;           ///< host names that the server accepts
    http::SharedOrigins origins;     ///< of pages that may read an archive
    std::filesystem::path facts;     ///< folder for the facts of worlds; empty: they are not stored
};
/// Derives the plan; also fills in the world's and the server's options.
/// @throws UsageError for flags that cannot be combined, and for a token that would be sent to
/// another server and be this server's own, too; Error for a token file that cannot be read
[[nodiscard]] Plan finish(Options& options);

/// Prints, on standard output, what is served and what the server will do.
void announce(const worlds::ServedWorld& world, const Options& options, const Plan& plan,
              const std::string& url);

/// Reports the progress of preparing: a bar on a terminal, else a log line now and then. Not
/// thread-safe.
class PrepareProgress {
public:
    /// @param bar whether standard error is a terminal and the log has the text format
    explicit PrepareProgress(bool bar) : m_bar(bar) {}
    void show(const boxes::Preparer::Progress& now);
    void end(const boxes::Preparer::Progress& now);  ///< the final report

private:
    using Clock = std::chrono::steady_clock;
    bool m_bar;
    std::uint64_t m_reported_percent = 0;
    Clock::time_point m_start = Clock::now();
};

/// Opens the world and serves it until SIGINT or SIGTERM, or makes all of its boxes
/// (--prepare-only).
/// @return kHoles when boxes could not be prepared
/// @throws Error, UsageError
[[nodiscard]] util::ExitCode serve(Options& options);

}  // namespace terravox::serve
