#include "raytracer/apps/commands/render_pool_arguments.hpp"

#include <CLI/CLI.hpp>

#include <charconv>
#include <cstdio>

#include "common/thread/parallel.hpp"
#include "common/util/command_line.hpp"
#include "common/util/secret.hpp"

namespace terravox::commands {

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
    command
        .add_option("--worker", args.workers,
                    "HOST[:PORT] of a worker daemon to render on, too; may be given several times "
                    "(port 7878)")
        ->expected(1)
        ->take_all()
        ->allow_extra_args(false)
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

std::chrono::milliseconds parse_time(const std::string& flag, const std::string& text) {
    double value = 0;
    const char* end = text.data() + text.size();
    const auto [at, failed] = std::from_chars(text.data(), end, value);
    const std::string unit(at, end);
    const double scale = unit.empty() || unit == "s"    ? 1
                         : unit == "ms"                 ? 0.001
                         : unit == "m" || unit == "min" ? 60
                         : unit == "h"                  ? 3600
                                                        : 0;
    constexpr double kMax_s = 366 * 86400.0;
    if (failed != std::errc{} || scale == 0 || !(value >= 0 && value * scale <= kMax_s))
        throw util::UsageError("read " + flag + " " + text +
                               ": allowed: a span of time up to a year, such as 60s, 5m or 2h");
    return std::chrono::milliseconds(static_cast<std::int64_t>(value * scale * 1000));
}

}  // namespace terravox::commands
