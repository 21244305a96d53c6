#pragma once

#include <string>

#include "voxelserver/http/box_replies.hpp"
#include "voxelserver/http/server.hpp"
#include "voxelserver/voxelize/lidar_world.hpp"

namespace CLI {
class App;
}

namespace terravox::http {

/// The command line of terravox-voxelserver.
struct Options {
    voxelize::LidarWorldOptions world;
    ServerOptions server;
    int memory_mib = 2048;    ///< of which three quarters for the world, a quarter for compressed boxes
    int queue = 96;           ///< boxes that may wait to be made
    int request_threads = 0;  ///< 0 = as many as can make or wait, and some for everything else
    std::string cache;  ///< util::cache_dir
    std::string log_level = "info";
};

/// Declares the flags; they are stored into `options` when the app parses.
void add_options(CLI::App& app, Options& options);

/// Fills in what follows from the flags: the world's memory and the server's threads, and the options of the box replies.
[[nodiscard]] BoxRepliesOptions finish(Options& options);

}  // namespace terravox::http
