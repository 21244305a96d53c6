#include "voxelserver/serve/server/serve.hpp"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "common/geo/gdal.hpp"
#include "common/thread/parallel.hpp"
#include "common/util/error.hpp"
#include "common/util/folders.hpp"
#include "common/util/secret.hpp"
#include "voxelserver/make/voxelize/points/settings.hpp"
#include "voxelserver/make/worlds/kind/world_options.hpp"
#include "voxelserver/make/worlds/lidar/lidar_kind.hpp"
#include "voxelserver/serve/host/host_names.hpp"

namespace terravox::serve {
namespace {

// Connections in addition to those that make or wait for a box: for cached boxes, /healthz, and
// idle clients.
constexpr int kSpareThreads = 32;
// Memory that such a process needs before it caches anything: libraries, stacks, working memory of
// the threads.
constexpr std::size_t kBaseBytes = std::size_t{96} << 20;

constexpr std::size_t kMinImageBytes = std::size_t{8} << 20;

// CLI::Range lets "nan" pass.
std::chrono::milliseconds milliseconds(double seconds, const char* flag) {
    if (!std::isfinite(seconds))
        throw util::UsageError(std::string(flag) +
                               ": no number of seconds; --help lists what is allowed");
    return std::chrono::milliseconds(static_cast<std::int64_t>(seconds * 1000));
}

/// An option that is valid for some kinds of worlds only, and rejected for others.
template <class Value>
CLI::Option* add_kind_option(CLI::App& app, Options& o, const char* flag, Value& value,
                             const char* help) {
    return app.add_option(flag, value, help)->each([&o, flag](const std::string&) {
        o.kind_flags.emplace_back(flag);
    });
}

void add_lidar_options(CLI::App& app, Options& o) {
    app.add_option("--store", o.store, "store that terravox grab has filled, instead of inputs");
    app.add_option("--ortho", o.world.orthophotos,
                   "of LiDAR data and rasters of heights: orthophoto, or a folder of them; may be "
                   "given several times")
        ->expected(1)
        ->take_all();
    add_kind_option(app, o, "--classes", o.world.classes,
                    "of LiDAR data: class table, an id (asprs, nl-ahn, ...) or a file; default: "
                    "what the store says, or the one that is meant for such files");
    app.add_flag("--mark-unknown", o.world.mark_unknown,
                 "of LiDAR data: show points of classes that the table does not name in magenta, "
                 "instead of guessing them")
        ->each([&o](const std::string&) { o.kind_flags.emplace_back("--mark-unknown"); });
    add_kind_option(app, o, "--settings", o.world.settings,
                    "of LiDAR data: which voxelization steps run and how, a TOML file; default: "
                    "config/voxelize.toml");
    add_kind_option(app, o, "--steps", o.world.steps,
                    "of LiDAR data: voxelization steps that run: all, none, some of those listed "
                    "below, or -STEP,... for all but these; default: as --settings says");
    add_kind_option(app, o, "--photo", o.world.photo,
                    "of LiDAR data: colours of orthophotos, albedo (sun, shadow and sky are taken "
                    "out) or raw; default: as --settings says, albedo")
        ->check(CLI::IsMember({"albedo", "raw"}));
    app.footer(voxelize::steps_help());
    add_kind_option(app, o, "--crs", o.world.crs,
                    "of LiDAR data and rasters of heights: CRS, overriding what the files say: "
                    "EPSG:n or WKT");
    add_kind_option(app, o, "--vertical-unit", o.world.vertical_unit,
                    "of LiDAR data and rasters of heights: unit of heights, m, ft or us-ft; "
                    "default: from the CRS");
    add_kind_option(
        app, o, "--voxel", o.world.voxel_m,
        "edge of a voxel, metres; of LiDAR data, rasters of heights and generated worlds")
        ->capture_default_str();
}

void add_other_kinds_options(CLI::App& app, Options& o) {
    add_kind_option(app, o, "--dimension", o.world.dimension,
                    "of a Minecraft world: overworld, nether, end, or another's name")
        ->capture_default_str();
    add_kind_option(app, o, "--world-base-m", o.world.base_m,
                    "of rasters of heights: rock down to here, metres; default: a little below "
                    "the lowest");
    procedural::Settings& noise = o.world.generated;
    add_kind_option(app, o, "--generated-water-level", noise.water_level,
                    "of generated worlds: height of the sea, voxels")
        ->capture_default_str();
    add_kind_option(app, o, "--generated-world-height", noise.world_height,
                    "of generated worlds: how far the highest summits rise above the sea, voxels")
        ->capture_default_str();
    add_kind_option(app, o, "--generated-harmonics", noise.harmonics,
                    "of generated worlds: octaves of hills and ridges")
        ->capture_default_str();
    add_kind_option(app, o, "--generated-frequency", noise.frequency,
                    "of generated worlds: of the broadest hills, 1 / voxels")
        ->capture_default_str();
    add_kind_option(app, o, "--generated-smoothness", noise.smoothness,
                    "of generated worlds: height of an octave to that of the one before, 0 to 1")
        ->capture_default_str();
    add_kind_option(app, o, "--generated-trees", noise.trees,
                    "of generated worlds: trees, bushes and grass, true or false")
        ->capture_default_str();
    app.add_option("--processing-box-timeout-s", o.box_timeout_s,
                   "of voxel servers and archives on web servers: timeout for fetching a box, "
                   "seconds")
        ->capture_default_str()
        ->check(CLI::Range(1, 86400))
        ->each(
            [&o](const std::string&) { o.kind_flags.emplace_back("--processing-box-timeout-s"); });
}

void add_world_options(CLI::App& app, Options& o) {
    // The table of all kinds of worlds is in the module, which --help does without.
    app.add_option("inputs", o.world.inputs,
                   std::string(worlds::kLidarInputs) +
                       " or folders of them, the grabber's store, a box archive (.tvx), a "
                       "Luanti (Minetest) world (folder), a Minecraft world (folder or ZIP), a "
                       "raster of heights, generated:SEED, or the http:// address of a voxel "
                       "server or box archive");
    add_lidar_options(app, o);
    add_other_kinds_options(app, o);
    app.add_option("--cache", o.cache,
                   "folder that keeps prepared LiDAR squares and finished boxes for the next "
                   "start; none: nothing on disk (default: ~/.cache/terravox)");
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
                 "make all boxes ahead, while no request waits for another one");
    app.add_flag("--prepare-only", o.prepare_only,
                 "the same without serving, then end: 0 all made, 3 some cannot be made");
    app.add_flag("--no-ahead", o.no_ahead, "do not prefetch the neighbours of requested boxes");
}

void add_job_options(CLI::App& app, Options& o) {
    app.add_option("--jobs", o.jobs,
                   "analyses that clients may run at the same time, each in a process of its own; "
                   "0: none")
        ->capture_default_str()
        ->check(CLI::Range(0, 64));
    app.add_option("--job-cells", o.job_limits.max_cells, "cells of an analysis at most")
        ->capture_default_str()
        ->check(CLI::Range(std::int64_t{1}, std::int64_t{400'000'000}));
    app.add_option("--job-minutes", o.job_limits.max_minutes, "of an analysis at most")
        ->capture_default_str()
        ->check(CLI::Range(1, 10'000));
    app.add_option("--job-memory-mib", o.job_limits.memory_mib,
                   "memory of each analysis, in addition to --memory-mib, MiB")
        ->capture_default_str()
        ->check(CLI::Range(256, 1 << 20));
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
                   "host name by which clients address this server or its front, without a port; "
                   "may be given several times. Others are refused (421), as any web page could "
                   "make its own name lead here; always known: localhost, numeric addresses and, "
                   "with --bind beyond loopback, this machine's name")
        ->expected(1)
        ->take_all();
    app.add_option("--allow-origin", o.shared_origins,
                   "of box archives: origin whose web pages may read /v2/archive.tvx (CORS), such "
                   "as https://example.org, or * for any; may be given several times")
        ->expected(1)
        ->take_all();
    app.add_option("--token-file", o.token_file,
                   "file with the token that requests must bring, which only its owner may read; "
                   "default: the credential terravox.server-token of a systemd service, else "
                   "TERRAVOX_SERVER_TOKEN, else none");
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
                   "for running requests when the server has to stop, seconds")
        ->capture_default_str()
        ->check(CLI::Range(0.0, 3600.0));
    add_job_options(app, o);
    app.add_option("--log", o.log_level, "trace, debug, info, warn, error or off")
        ->capture_default_str();
    app.add_flag("--log-json", o.log_json, "log lines as JSON objects, for machines");
}

}  // namespace

void add_options(CLI::App& app, Options& o) {
    add_world_options(app, o);
    add_server_options(app, o);
}

namespace {

/// Name of the token among the credentials of the service (config/systemd).
constexpr const char* kTokenCredential = "terravox.server-token";

/// TERRAVOX_SERVER_TOKEN is the token that this server requires of its clients, unless the world is
/// another server's and TERRAVOX_SERVER_ORIGIN binds the token to that one: then it is sent there,
/// and must not be this server's, too.
std::string own_token(const Options& o) {
    const std::filesystem::path file = o.token_file.empty()
                                           ? util::find_credential(kTokenCredential)
                                           : std::filesystem::path(o.token_file);
    const char* origin = std::getenv("TERRAVOX_SERVER_ORIGIN");
    const bool is_bound = origin != nullptr && *origin != '\0';
    const bool is_remote =
        std::any_of(o.world.inputs.begin(), o.world.inputs.end(), worlds::is_http_address);
    if (!file.empty() || !is_bound || !is_remote)
        return util::find_token(file, util::kServerTokenVariable);
    if (!http::is_loopback(o.server.bind))
        throw util::UsageError(
            std::string("serve on ") + o.server.bind + ": " + util::kServerTokenVariable +
            " is the token of the server in TERRAVOX_SERVER_ORIGIN; allowed: a token of this "
            "server's own, by --token-file");
    return {};
}

}  // namespace

Plan finish(Options& o) {
    if (o.store.empty() == o.world.inputs.empty())
        throw util::UsageError(
            "open the world: " +
            std::string(o.store.empty() ? "neither inputs nor --store" : "inputs and --store") +
            "; allowed: one of them");
    Plan plan;
    plan.token = own_token(o);
    plan.names = http::HostNames(o.server.bind, o.public_names);
    plan.origins = http::SharedOrigins(o.shared_origins);
    const std::filesystem::path cache = util::cache_dir(o.cache);
    const std::size_t all = static_cast<std::size_t>(o.memory_mib) << 20;
    plan.image_bytes =
        std::clamp(all / 16, kMinImageBytes, static_cast<std::size_t>(geo::kGdalCache_bytes));
    const std::size_t others = all / 8 + kBaseBytes + plan.image_bytes;
    const std::size_t kept = std::max(all > others ? all - others : 0, all / 4);
    plan.map_bytes = kept / 16;
    plan.boxes.memory_bytes = kept / 4 - plan.map_bytes;
    plan.boxes.makers = thread::thread_count(o.world.threads);
    plan.boxes.queue = o.queue;
    plan.boxes.max_requests = std::max(
        (o.request_threads > 0 ? o.request_threads : plan.boxes.makers + o.queue + kSpareThreads) -
            kSpareThreads,
        1);
    // Everything is made in advance then.
    plan.boxes.ahead = !o.no_ahead && !o.prepare && !o.prepare_only;
    plan.boxes.disk_bytes = static_cast<std::uint64_t>(o.cache_mib) << 19;
    if (!cache.empty()) {
        plan.boxes.file = cache / "boxes-1.sqlite";
        plan.facts = cache / "worlds";
    }
    if (o.prepare_only && cache.empty())
        throw util::UsageError(
            "prepare the world: no cache folder to keep it in; allowed: --cache DIR");
    o.world.cache_dir = cache;
    plan.square_bytes = plan.boxes.disk_bytes;
    o.world.box_timeout = std::chrono::seconds(o.box_timeout_s);
    o.world.memory_bytes = kept - plan.boxes.memory_bytes - plan.map_bytes;
    o.server.request_threads = o.request_threads > 0
                                   ? o.request_threads
                                   : plan.boxes.makers + plan.boxes.queue + kSpareThreads;
    o.server.request_timeout = milliseconds(o.header_timeout_s, "--header-timeout-s");
    o.server.keep_alive_timeout = milliseconds(o.keep_alive_s, "--keep-alive-s");
    o.job_limits.threads = o.world.threads;
    o.server.drain_timeout = milliseconds(o.drain_s, "--drain-s");
    return plan;
}

}  // namespace terravox::serve
