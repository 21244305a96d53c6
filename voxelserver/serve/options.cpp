#include "voxelserver/serve/options.hpp"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <cmath>

#include "common/geo/gdal.hpp"
#include "common/thread/parallel.hpp"
#include "common/util/cache_dir.hpp"
#include "common/util/error.hpp"
#include "common/util/secret.hpp"

namespace terravox::serve {
namespace {

// Connections beyond those that make a box or wait for it: for boxes in the cache, /healthz, and
// idle clients.
constexpr int kSpareThreads = 32;
// Of the memory that a process of this kind takes before it keeps anything: libraries, stacks, what
// the threads have at work.
constexpr std::size_t kBaseBytes = std::size_t{96} << 20;

constexpr std::size_t kLeastImageBytes = std::size_t{8} << 20;

// CLI::Range lets "nan" pass.
std::chrono::milliseconds milliseconds(double seconds, const char* flag) {
    if (!std::isfinite(seconds))
        throw UsageError(std::string(flag) +
                         ": no number of seconds; --help lists what is allowed");
    return std::chrono::milliseconds(static_cast<std::int64_t>(seconds * 1000));
}

void add_world_options(CLI::App& app, Options& o) {
    app.add_option("inputs", o.world.files, "LAS, LAZ or COPC files, or folders of them");
    app.add_option("--store", o.store, "store that terravox grab has filled, instead of files");
    app.add_option("--ortho", o.world.orthophotos,
                   "orthophoto, or a folder of them; may be given several times")
        ->expected(1)
        ->take_all();
    app.add_option("--classes", o.world.classes,
                   "class table: an id (asprs, nl-ahn, ...) or a file; default: what the store "
                   "says, or asprs");
    app.add_option(
        "--settings", o.world.settings,
        "which voxelization steps run and how: a TOML file; default: config/voxelize.toml");
    app.add_option("--cache", o.cache,
                   "folder that keeps prepared LiDAR squares and finished boxes for the next "
                   "start; none: nothing on disk (default: ~/.cache/terravox)");
    app.add_option("--crs", o.world.crs,
                   "CRS of the files, overriding what they say: EPSG:n or WKT");
    app.add_option("--voxel", o.world.voxel_m, "edge of a voxel, metres")->capture_default_str();
    app.add_option("--vertical-unit", o.world.vertical_unit,
                   "unit of heights: m, ft or us-ft; default: from the CRS");
    app.add_option("--threads", o.world.threads, "threads that make boxes; 0: one for each core")
        ->capture_default_str()
        ->check(CLI::Range(0, 1024));
    app.add_option("--memory-mib", o.memory_mib, "memory of the whole process, MiB")
        ->capture_default_str()
        ->check(CLI::Range(128, 1 << 24));
    app.add_option(
           "--cache-mib", o.cache_mib,
           "limit of the cache folder, MiB: half for prepared squares, half for finished boxes")
        ->capture_default_str()
        ->check(CLI::Range(std::int64_t{64}, std::int64_t{1} << 30));
    app.add_flag("--prepare", o.prepare,
                 "make all boxes ahead, while nobody waits for another one");
    app.add_flag("--prepare-only", o.prepare_only,
                 "the same without serving, then end: 0 all made, 3 some cannot be made");
    app.add_flag("--no-ahead", o.no_ahead, "do not make the neighbours of what was asked for");
}

void add_server_options(CLI::App& app, Options& o) {
    app.add_option("--port", o.server.port, "port to listen on; 0: any free one")
        ->capture_default_str()
        ->check(CLI::Range(0, 65535));
    app.add_option(
           "--bind", o.server.bind,
           "IPv4 address to listen on; 0.0.0.0: all networks. Clients that do not finish their "
           "requests are closed when they take threads from others; "
           "those that read replies slowly are not: config/nginx is a front for open networks")
        ->capture_default_str();
    app.add_option("--public-name", o.public_names,
                   "host name by which clients ask for this server or its front, without a port; "
                   "may be given several times. Others are refused (421), as any web page could "
                   "make its own name lead here; always known: localhost, numeric addresses and, "
                   "with --bind beyond loopback, this machine's name")
        ->expected(1)
        ->take_all();
    app.add_option("--token-file", o.token_file,
                   "file with the token that requests must bring, which only its owner may read; "
                   "default: TERRAVOX_SERVER_TOKEN, or none");
    app.add_option("--tls-cert", o.server.tls_certificate,
                   "PEM file with certificate and private key: serve https");
    app.add_option("--request-threads", o.request_threads,
                   "connections served at the same time; 0: --threads + --queue + 32")
        ->capture_default_str()
        ->check(CLI::Range(0, 4096));
    app.add_option("--queue", o.queue,
                   "boxes that may wait to be made; further requests for boxes get 503")
        ->capture_default_str()
        ->check(CLI::Range(0, 4096));
    app.add_option(
           "--header-timeout-s", o.header_timeout_s,
           "for a whole header, for a body, and for each bit of progress of a reply, seconds")
        ->capture_default_str()
        ->check(CLI::Range(0.1, 3600.0));
    app.add_option("--keep-alive-s", o.keep_alive_s,
                   "between two requests of a connection, seconds")
        ->capture_default_str()
        ->check(CLI::Range(0.1, 3600.0));
    app.add_option("--drain-s", o.drain_s,
                   "for running requests when the server is told to stop, seconds")
        ->capture_default_str()
        ->check(CLI::Range(0.0, 3600.0));
    app.add_option("--log", o.log_level, "trace, debug, info, warn, error or off")
        ->capture_default_str();
    app.add_flag("--log-json", o.log_json, "log lines as JSON objects, for machines");
}

}  // namespace

void add_options(CLI::App& app, Options& o) {
    add_world_options(app, o);
    add_server_options(app, o);
}

Plan finish(Options& o) {
    if (o.store.empty() == o.world.files.empty())
        throw UsageError(
            "open the world: " +
            std::string(o.store.empty() ? "neither files nor --store" : "files and --store") +
            "; allowed: one of them");
    Plan plan;
    plan.token = util::find_server_token(o.token_file);
    plan.names = net::HttpNames(o.server.bind, o.public_names);
    const std::filesystem::path cache = util::cache_dir(o.cache);
    const std::size_t all = static_cast<std::size_t>(o.memory_mib) << 20;
    plan.image_bytes =
        std::clamp(all / 16, kLeastImageBytes, static_cast<std::size_t>(geo::kGdalCache_bytes));
    const std::size_t others = all / 8 + kBaseBytes + plan.image_bytes,
                      kept = std::max(all > others ? all - others : 0, all / 4);
    plan.map_bytes = kept / 16;
    plan.boxes.memory_bytes = kept / 4 - plan.map_bytes;
    plan.boxes.makers = thread::thread_count(o.world.threads);
    plan.boxes.queue = o.queue;
    plan.boxes.asking = std::max(
        (o.request_threads > 0 ? o.request_threads : plan.boxes.makers + o.queue + kSpareThreads) -
            kSpareThreads,
        1);
    plan.boxes.ahead =
        !o.no_ahead && !o.prepare && !o.prepare_only;  // everything is made ahead then
    plan.boxes.disk_bytes = static_cast<std::uint64_t>(o.cache_mib) << 19;
    if (!cache.empty())
        plan.boxes.file = cache / "boxes-1.sqlite", plan.facts = cache / "worlds";
    if (o.prepare_only && cache.empty())
        throw UsageError("prepare the world: no cache folder to keep it in; allowed: --cache DIR");
    o.world.cache_dir = cache;
    o.world.cache_bytes = plan.boxes.disk_bytes;
    o.world.memory_bytes = kept - plan.boxes.memory_bytes - plan.map_bytes;
    o.server.request_threads = o.request_threads > 0
                                   ? o.request_threads
                                   : plan.boxes.makers + plan.boxes.queue + kSpareThreads;
    o.server.request_timeout = milliseconds(o.header_timeout_s, "--header-timeout-s");
    o.server.keep_alive_timeout = milliseconds(o.keep_alive_s, "--keep-alive-s");
    o.server.drain_timeout = milliseconds(o.drain_s, "--drain-s");
    return plan;
}

}  // namespace terravox::serve
