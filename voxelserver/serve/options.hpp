#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "voxelserver/boxes/box_cache.hpp"
#include "voxelserver/http/server.hpp"
#include "voxelserver/sockets/http_host.hpp"
#include "voxelserver/worlds/kind/world_options.hpp"

namespace CLI {
class App;
}

namespace terravox::serve {

/// The command line of terravox-voxelserver.
struct Options {
    Options() { world.classes.clear(); }
    worlds::WorldOptions world;  ///< classes: empty = what the store says, or "asprs"
    /// Flags that were given, of those that mean something for some kinds of worlds only.
    std::vector<std::string> kind_flags;
    http::ServerOptions server;
    std::vector<std::string> public_names;  ///< host names, beside those of net::HttpNames
    std::filesystem::path store;            ///< that the grabber fills; empty: the inputs are named
    int memory_mib = 2048;                  ///< of the whole process
    std::int64_t cache_mib =
        40960;  ///< of the cache folder: half for prepared squares, half for finished boxes
    int box_timeout_s = 30;   ///< for a box of another server
    int queue = 96;           ///< boxes that may wait to be made
    int request_threads = 0;  ///< 0 = as many as can make or wait, and some for everything else
    double header_timeout_s = 5, keep_alive_s = 2, drain_s = 10;
    bool no_ahead = false, prepare = false, prepare_only = false;
    std::string cache;       ///< util::cache_dir
    std::string token_file;  ///< "" = TERRAVOX_SERVER_TOKEN of the environment, or no token
    std::string log_level = "info";
    bool log_json = false;
};

/// Whether an input is the address of a voxel server or of a box archive.
[[nodiscard]] bool is_address(const std::string& input) noexcept;

/// Declares the flags; they are stored into `options` when the app parses.
void add_options(CLI::App& app, Options& options);

/// What follows from the flags.
struct Plan {
    boxes::BoxCacheOptions boxes;
    std::uint64_t square_bytes = 0;  ///< of disk, for prepared LiDAR squares
    std::size_t map_bytes = 0;       ///< of memory, for the map
    std::size_t image_bytes = 0;     ///< of memory, for what is decoded of images
    std::string token;               ///< "" = none
    sockets::HttpNames names;        ///< that the server answers to
    std::filesystem::path facts;     ///< folder for what is known of worlds; empty: nothing is kept
};
/// Fills in the world's and the server's options, too. @throws UsageError for flags that do not go
/// together, and for a token that would be shown to another server and be this server's own, too;
/// Error for a token file that cannot be read
[[nodiscard]] Plan finish(Options& options);

}  // namespace terravox::serve
