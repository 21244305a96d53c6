#include "raytracer/apps/commands/run_arguments.hpp"

#include <CLI/CLI.hpp>
#include <cstdio>

#include "common/thread/parallel.hpp"
#include "common/util/command_line.hpp"
#include "common/util/log.hpp"
#include "common/util/numbers.hpp"
#include "common/util/secret.hpp"
#include "common/voxel/log_damage.hpp"
#include "raytracer/apps/commands/arguments/world_arguments.hpp"

namespace terravox::commands {
namespace {

/// Parses a duration such as 90, 90s, 5m or 2h.
/// @throws UsageError naming the flag
std::chrono::milliseconds parse_time(const std::string& flag, const std::string& text) {
    std::string_view unit = text;
    const auto value = util::take_number<double>(unit);
    const double scale = unit.empty() || unit == "s"    ? 1
                         : unit == "ms"                 ? 0.001
                         : unit == "m" || unit == "min" ? 60
                         : unit == "h"                  ? 3600
                                                        : 0;
    constexpr double kMax_s = 366 * 86400.0;
    if (!value || scale == 0 || !(*value >= 0 && *value * scale <= kMax_s))
        throw util::UsageError("read " + flag + " " + text +
                               ": allowed: a span of time up to a year, such as 60s, 5m or 2h");
    return std::chrono::milliseconds(static_cast<std::int64_t>(*value * scale * 1000));
}

}  // namespace

void add_grid_arguments(CLI::App& command, GridArguments& args) {
    command.add_option("--area", args.area,
                       "west,south,east,north in the world's CRS; x0,z0,x1,z1 in voxels where it "
                       "has none; default: all");
    command.add_option("--resolution", args.resolution_m,
                       "edge of a cell, metres; default: that of a voxel");
}

std::vector<double> parse_area(const std::string& command, const GridArguments& args) {
    return list_numbers(command, "--area", args.area, 4,
                        "west,south,east,north, or x0,z0,x1,z1 in a world without a CRS");
}

std::optional<net::Credentials> CredentialArguments::find() const {
    net::Credentials out;
    const int named = static_cast<int>(!ca.empty()) + static_cast<int>(!certificate.empty()) +
                      static_cast<int>(!key.empty());
    if (named != 0 && named != 3)
        throw util::UsageError(
            "use certificates: only some of --tls-ca, --tls-cert and --tls-key are given; allowed: "
            "all three, or none");
    if (named == 3) {
        if (!token_file.empty())
            throw util::UsageError(
                "use certificates: --token-file is given, too; allowed: one or the other");
        out.ca = ca;
        out.certificate = certificate;
        out.key = key;
        return out;
    }
    out.token = util::find_token(token_file, util::kFarmTokenVariable);
    if (out.token.empty())
        return std::nullopt;
    return out;
}

net::Credentials CredentialArguments::credentials(bool listens, const std::string& how) const {
    if (auto found = find())
        return *std::move(found);
    if (!listens)
        throw util::UsageError(
            "join a farm: no token; give --token-file FILE, or TERRAVOX_FARM_TOKEN in the "
            "environment, or certificates (terravox farm certs)");
    net::Credentials out;
    out.token = util::make_token();
    std::fprintf(stderr, "token: %s\n%s\n", out.token.c_str(), how.c_str());
    return out;
}

void add_credential_arguments(CLI::App& command, CredentialArguments& args) {
    command
        .add_option("--token-file", args.token_file,
                    "file with the farm's token, which only its owner may read; default: "
                    "TERRAVOX_FARM_TOKEN in the environment")
        ->group("Farm");
    command
        .add_option(
            "--tls-ca", args.ca,
            "certificates instead of a token: the CA's (PEM; terravox farm certs makes all)")
        ->group("Farm");
    command.add_option("--tls-cert", args.certificate, "this program's certificate (PEM)")
        ->group("Farm");
    command.add_option("--tls-key", args.key, "this program's private key (PEM)")->group("Farm");
}

void add_render_pool_arguments(CLI::App& command, RenderPoolArguments& args) {
    allow_several(
        command.add_option(
            "--worker", args.workers,
            "HOST[:PORT] of a worker daemon to render on, too; may be given several times "
            "(port 7878)"))
        ->group("Farm");
    command
        .add_option("--listen", args.listen,
                    "[HOST]:PORT to wait at for workers that join (terravox worker --join)")
        ->group("Farm");
    util::refuse_removed_option(command, "--discover",
                                "name each worker by --worker HOST, or wait for them by --listen");
    command.add_flag("--green", args.green, "trace on the coordinating thread, too, in slices")
        ->group("Farm");
    command
        .add_option("--give-up", args.give_up,
                    "when there has been no worker for so long (60s, 5m) since the last tile, end "
                    "with what "
                    "there is; a busy one is none; default: wait")
        ->group("Farm");
    add_credential_arguments(command, args.credentials);
}

render::RenderPoolOptions RenderPoolArguments::options(const scene::Scene& scene) const {
    render::RenderPoolOptions out;
    out.green = green;
    for (const std::string& worker : workers) {
        out.farm.dial.push_back(sockets::Address::parse(worker, net::kWorkerPort));
        if (out.farm.dial.back().port == 0)
            throw util::UsageError("dial --worker " + worker + ": port 0; allowed: 1 to 65535");
    }
    if (!listen.empty())
        out.farm.listen = sockets::Address::parse(listen, net::kCoordinatorPort);
    if (!give_up.empty())
        out.give_up = parse_time("--give-up", give_up);
    out.threads = scene.processing.threads ? *scene.processing.threads
                  : green                  ? 0
                                           : thread::thread_count(0);
    if (out.farm.any())
        out.farm.credentials = credentials.credentials(
            !listen.empty() && workers.empty(),
            "workers join with: TERRAVOX_FARM_TOKEN=TOKEN terravox worker --join HOST:" +
                (out.farm.listen ? std::to_string(out.farm.listen->port) : std::string("PORT")));
    return out;
}

void add_verbosity_flags(CLI::App& command, Verbosity& args) {
    CLI::Option* const quiet = command.add_flag("-q,--quiet", args.quiet, "print errors only");
    command.add_flag("-v,--verbose", args.verbose, "print the time of each step and the memory")
        ->excludes(quiet);
}

util::ExitCode report_gaps(const render::RenderStatistics& statistics, const std::string& what) {
    if (!statistics.counts.holes.empty())
        util::log_error("the {} has holes: {} boxes could not be loaded", what,
                        statistics.counts.holes.size());
    if (statistics.counts.missing > 0)
        util::log_error("the {} lacks {} tiles: no processor was left to render them", what,
                        statistics.counts.missing);
    if (!statistics.damage.empty())
        voxel::log_damage(statistics.damage);
    return statistics.has_holes() ? util::ExitCode::kHoles : util::ExitCode::kDone;
}

}  // namespace terravox::commands
