#include "voxelserver/http/options.hpp"

#include <CLI/CLI.hpp>

#include "common/thread/parallel.hpp"
#include "common/util/cache_dir.hpp"

namespace terravox::http {
namespace {

// Connections beyond those that make a box or wait for it: for boxes in the cache, /healthz, and idle clients.
constexpr int kSpareThreads = 32;

}  // namespace

void add_options(CLI::App& app, Options& o) {
    app.add_option("inputs", o.world.files, "LAS, LAZ or COPC files, or folders of them")->required();
    app.add_option("--ortho", o.world.orthophotos, "orthophoto, or a folder of them; may be given several times")->expected(1)->take_all();
    app.add_option("--classes", o.world.classes, "class table: an id (asprs, nl-ahn, ...) or a file")->capture_default_str();
    app.add_option("--settings", o.world.settings, "which voxelization steps run and how: a TOML file; default: config/voxelize.toml");
    app.add_option("--cache", o.cache, "folder that keeps prepared LiDAR squares for the next start; none: nothing on disk (default: ~/.cache/terravox)");
    app.add_option("--crs", o.world.crs, "CRS of the files, overriding what they say: EPSG:n or WKT");
    app.add_option("--voxel", o.world.voxel_m, "edge of a voxel, metres")->capture_default_str();
    app.add_option("--vertical-unit", o.world.vertical_unit, "unit of heights: m, ft or us-ft; default: from the CRS");
    app.add_option("--port", o.server.port, "port to listen on; 0: any free one")->capture_default_str()->check(CLI::Range(0, 65535));
    app.add_option("--bind", o.server.bind, "address to listen on; 0.0.0.0: all networks")->capture_default_str();
    app.add_option("--threads", o.world.threads, "threads that make boxes; 0: one for each core")->capture_default_str()->check(CLI::Range(0, 1024));
    app.add_option("--memory-mib", o.memory_mib, "memory for the world and for compressed boxes, MiB")
        ->capture_default_str()
        ->check(CLI::Range(64, 1 << 24));
    app.add_option("--request-threads", o.request_threads,
                   "connections served at the same time; 0: --threads + --queue + 32")
        ->capture_default_str()
        ->check(CLI::Range(0, 4096));
    app.add_option("--queue", o.queue, "boxes that may wait to be made; further requests for boxes get 503")
        ->capture_default_str()
        ->check(CLI::Range(0, 4096));
    app.add_option("--log", o.log_level, "trace, debug, info, warn, error or off")->capture_default_str();
}

BoxRepliesOptions finish(Options& o) {
    o.world.cache_dir = util::cache_dir(o.cache);
    const std::size_t bytes = static_cast<std::size_t>(o.memory_mib) << 20;
    BoxRepliesOptions replies;
    replies.makers = thread::thread_count(o.world.threads);
    replies.queue = o.queue;
    replies.memory_bytes = bytes / 4;
    o.world.memory_bytes = bytes - replies.memory_bytes;
    o.server.request_threads = o.request_threads > 0 ? o.request_threads : replies.makers + replies.queue + kSpareThreads;
    return replies;
}

}  // namespace terravox::http
