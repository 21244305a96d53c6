#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>

#include "common/thread/parallel.hpp"
#include "common/thread/stop.hpp"
#include "common/util/build_id.hpp"
#include "common/util/files.hpp"
#include "common/util/log.hpp"
#include "common/util/process_memory.hpp"
#include "common/util/secret.hpp"
#include "common/util/text.hpp"
#include "common/util/version.hpp"
#include "raytracer/apps/commands/arguments/world_arguments.hpp"
#include "raytracer/apps/commands/commands.hpp"
#include "raytracer/apps/commands/run_arguments.hpp"
#include "raytracer/farm/net/certificates.hpp"
#include "raytracer/farm/wire/frames.hpp"
#include "raytracer/farm/worker/metrics_page.hpp"
#include "raytracer/farm/worker/worker_config.hpp"
#include "raytracer/farm/worker/worker_daemon.hpp"

namespace terravox::commands {
namespace {

struct FarmArguments {
    std::string folder = "farm-certs";
    std::vector<std::string> names;
    std::vector<std::string> revoked;
    std::string role;
    int days = 365;
    std::vector<std::string> addresses;
    bool json = false;
    std::string worker;
    CredentialArguments credentials;
};

util::ExitCode make_certificates(const FarmArguments& args) {
    if (!args.revoked.empty()) {
        net::revoke_certs(args.folder, args.revoked);
        std::printf(
            "wrote %s: copy it next to ca.pem on each machine; connections from then on are "
            "refused "
            "to what it names\n",
            net::find_revocation_list(std::filesystem::path(args.folder) / "ca.pem").c_str());
        return util::ExitCode::kDone;
    }
    net::make_certs(args.folder, args.names, args.days, args.role);
    std::printf(
        "wrote %s: give each machine ca.pem, and one certificate with its key; keep ca.key away "
        "from all of them\n",
        args.folder.c_str());
    return util::ExitCode::kDone;
}

/// @param question a StatusRequest or a Pause
farm::Status ask(const sockets::Address& address, const net::Credentials& credentials,
                 farm::Frame question) {
    auto link = net::dial(address, credentials, std::chrono::seconds(5));
    farm::OwnHello own;
    own.role = farm::OBSERVER;
    (void)farm::meet(*link, farm::make_hello(own), {farm::WORKER, farm::COORDINATOR});
    link->send(std::move(question));
    while (auto frame = link->receive()) {
        if (frame->has_status())
            return std::move(*frame->mutable_status());
        if (frame->has_refusal())
            throw util::Error("query " + address.text() +
                              ": it refuses: " + frame->refusal().reason());
    }
    throw util::Error("query the state of " + address.text() + ": the link ended");
}

nlohmann::json to_json(const std::string& address, const farm::Status& s) {
    nlohmann::json members = nlohmann::json::array();
    for (const auto& m : s.members())
        members.push_back({{"name", m.name()},
                           {"kind", m.kind()},
                           {"peer", m.peer()},
                           {"state", m.state()},
                           {"threads", m.threads()},
                           {"tiles", m.tiles()},
                           {"pixels", m.pixels()},
                           {"pixels_per_s", m.pixels_per_s()},
                           {"latency_s", m.latency_s()},
                           {"memory_bytes", m.memory_bytes()},
                           {"busy_share", m.busy_share()},
                           {"leases", m.leases()}});
    return {{"address", address},
            {"role", s.role() == farm::COORDINATOR ? "coordinator" : "worker"},
            {"name", s.name()},
            {"software", s.software()},
            {"uptime_s", s.uptime_s()},
            {"tiles_done", s.tiles_done()},
            {"tiles_total", s.tiles_total()},
            {"memory_bytes", s.memory_bytes()},
            {"members", members}};
}

void print(const std::string& address, const farm::Status& s) {
    const bool coordinator = s.role() == farm::COORDINATOR;
    std::printf("%s: %s %s, %s, up %.0f s, %llu MiB, %llu", address.c_str(),
                coordinator ? "coordinator" : "worker", util::printable(s.name()).c_str(),
                util::printable(s.software()).c_str(), s.uptime_s(),
                static_cast<unsigned long long>(s.memory_bytes() >> 20),
                static_cast<unsigned long long>(s.tiles_done()));
    if (coordinator)
        std::printf(" of %llu", static_cast<unsigned long long>(s.tiles_total()));
    std::printf(" tiles done\n");
    if (s.members().empty())
        return;
    std::printf("  %-28s %-11s %-9s %7s %9s %10s %8s %6s %6s\n",
                coordinator ? "processor" : "works for", "kind", "state", "threads", "tiles",
                "kpixel/s", "latency", "leases", "busy");
    for (const auto& m : s.members())
        std::printf("  %-28.28s %-11s %-9s %7u %9llu %10.1f %5.1f ms %6u %4.0f %%\n",
                    util::printable(m.name()).c_str(), util::printable(m.kind()).c_str(),
                    util::printable(m.state()).c_str(), m.threads(),
                    static_cast<unsigned long long>(m.tiles()), m.pixels_per_s() / 1e3,
                    m.latency_s() * 1e3, m.leases(), 100 * m.busy_share());
}

util::ExitCode ask_all(const FarmArguments& args, const farm::Frame& question) {
    util::set_up_log("error");
    const net::Credentials credentials = args.credentials.credentials(false, "");
    nlohmann::json all = nlohmann::json::array();
    for (const std::string& text : args.addresses) {
        const sockets::Address address = sockets::Address::parse(text, net::kWorkerPort);
        const farm::Status status = ask(address, credentials, question);
        if (args.json)
            all.push_back(to_json(address.text(), status));
        else
            print(address.text(), status);
    }
    if (args.json)
        std::printf("%s\n",
                    all.dump(2, ' ', true, nlohmann::json::error_handler_t::replace).c_str());
    return util::ExitCode::kDone;
}

}  // namespace

std::function<util::ExitCode()> add_farm_command(CLI::App& app) {
    auto args = std::make_shared<FarmArguments>();
    CLI::App* farm = app.add_subcommand(
        "farm", "Tokens and certificates for a farm, the state of its members, and pausing them");
    farm->require_subcommand(1);
    CLI::App* token = farm->add_subcommand(
        "token",
        "Print a new random token, for a farm or a voxel server: (umask 077; terravox farm token > "
        "FILE)");
    CLI::App* certs = farm->add_subcommand(
        "certs", "Make a small CA, and certificates of it for coordinators and workers");
    CLI::Option* names = certs->add_option(
        "names", args->names, "one certificate for each; default: coordinator, worker");
    certs->add_option("--role", args->role,
                      "role of all that are made: worker, or coordinator (renders, asks for "
                      "status, pauses); default: coordinator for that name, else worker");
    allow_several(
        certs->add_option(
            "--revoke", args->revoked,
            "revoke NAME.pem of the folder instead of making certificates: adds it to ca.crl "
            "there; may be given several times. Revoke first, then make another of that name"))
        ->excludes(names);
    certs
        ->add_option("-o,--output", args->folder,
                     "folder; where it has a CA, that one makes the certificates")
        ->capture_default_str();
    certs->add_option("--days", args->days, "how long they are valid")->capture_default_str();
    CLI::App* status = farm->add_subcommand(
        "status", "Show the state of worker daemons and coordinators (render --listen)");
    status->add_option("addresses", args->addresses, "HOST[:PORT] (port 7878)")->required();
    status->add_flag("--json", args->json, "as JSON");
    CLI::App* pause =
        farm->add_subcommand("pause", "Give workers no new tiles; what they have they finish");
    CLI::App* resume = farm->add_subcommand("resume", "Give workers tiles again");
    for (CLI::App* command : {pause, resume}) {
        command
            ->add_option(
                "addresses", args->addresses,
                "HOST[:PORT] (port 7878) of worker daemons, or of coordinators (render --listen)")
            ->required();
        command->add_option("--worker", args->worker,
                            "of a coordinator: its worker of this name; default: all workers");
    }
    for (CLI::App* command : {status, pause, resume})
        add_credential_arguments(*command, args->credentials);
    return [args, token, certs, pause, resume] {
        if (token->parsed()) {
            std::printf("%s\n", util::make_token().c_str());
            return util::ExitCode::kDone;
        }
        if (certs->parsed())
            return make_certificates(*args);
        farm::Frame question;
        if (pause->parsed() || resume->parsed()) {
            question.mutable_pause()->set_on(pause->parsed());
            question.mutable_pause()->set_worker(args->worker);
        } else {
            question.mutable_status_request();
        }
        return ask_all(*args, question);
    };
}

namespace {

void set_up_log(const farm::WorkerConfig& config) {
    util::set_up_log(config.log, config.log_json ? util::LogFormat::kJson : util::LogFormat::kText);
}

/// Without credentials, a daemon that only listens makes a token and prints it for use by
/// coordinators.
net::Credentials credentials_or_new(const farm::WorkerConfig& config) {
    if (!config.tls_ca.empty() || !config.join.empty() ||
        !util::find_token(config.token_file, util::kFarmTokenVariable).empty())
        return farm::make_credentials(config);
    net::Credentials out;
    out.token = util::make_token();
    std::fprintf(stderr,
                 "token: %s\ncoordinators render here with: TERRAVOX_FARM_TOKEN=TOKEN terravox "
                 "render --worker HOST:%u ...\n",
                 out.token.c_str(), static_cast<unsigned>(config.listen->port));
    return out;
}

farm::WorkerDaemonOptions make_options(const farm::WorkerConfig& config) {
    farm::WorkerDaemonOptions out;
    out.listen = config.listen;
    out.join = config.join;
    out.name = config.name;
    out.once = config.once;
    out.sessions = config.sessions;
    out.threads = thread::thread_count(config.threads);
    out.memory_bytes = static_cast<std::size_t>(config.memory_mib) << 20;
    const auto span = [](double seconds) {
        return std::chrono::milliseconds(static_cast<std::int64_t>(seconds * 1000));
    };
    out.timeout = span(config.drain_s);
    if (config.idle_s > 0)
        out.idle = span(config.idle_s);
    return out;
}

/// Reads the configuration again; an invalid one changes nothing. Used by one thread at a time.
class Reloader {
public:
    Reloader(const farm::WorkerArguments& arguments, farm::WorkerConfig running,
             farm::WorkerDaemon& daemon)
        : m_arguments(arguments), m_running(std::move(running)), m_daemon(daemon) {}

    void reload() noexcept {
        try {
            const farm::WorkerConfig wanted = farm::load_worker_config(m_arguments);
            const farm::WorkerConfigChange change = farm::difference(m_running, wanted);
            m_running = farm::reloaded(m_running, wanted);
            set_up_log(m_running);
            m_daemon.reload(make_options(m_running));
            util::log_info("configuration read again; changed: {}",
                           change.now.empty() ? "nothing" : util::comma_list(change.now));
            if (!change.restart.empty())
                util::log_warn("after a restart only: {}", util::comma_list(change.restart));
        } catch (const std::exception& e) {
            util::log_error("{}; the configuration stays as it was", e.what());
        }
    }

private:
    const farm::WorkerArguments& m_arguments;
    farm::WorkerConfig m_running;
    farm::WorkerDaemon& m_daemon;
};

farm::MetricsAddress metrics_address(const farm::WorkerConfig& config) {
    farm::MetricsAddress out{config.metrics->host, config.metrics->port};
    std::istringstream names(config.metrics_names);
    for (std::string name; names >> name;)
        out.names.push_back(name);
    return out;
}

util::ExitCode run_worker(const farm::WorkerArguments& arguments) {
    const farm::WorkerConfig config = farm::load_worker_config(arguments);
    set_up_log(config);
    util::raise_open_file_limit();
    farm::WorkerDaemonOptions options = make_options(config);
    options.http = farm::make_http_access(config);
    options.credentials = credentials_or_new(config);
    farm::WorkerDaemon daemon(std::move(options));
    std::unique_ptr<farm::MetricsPage> page;
    if (config.metrics) {
        page = std::make_unique<farm::MetricsPage>(metrics_address(config),
                                                   [&daemon] { return daemon.totals(); });
        util::log_info("page of metrics at port {}", page->port());
    }
    {
        Reloader reloader(arguments, config, daemon);
        thread::StopSignals::Options handling;
        handling.on_hangup = [&reloader] { reloader.reload(); };
        const thread::StopSignals signals(std::move(handling));
        if (daemon.port() != 0)
            util::log_info("waiting for coordinators on port {}", daemon.port());
        daemon.run(signals.token());
    }
    return util::ExitCode::kDone;
}

}  // namespace

std::function<util::ExitCode()> add_worker_command(CLI::App& app) {
    auto arguments = std::make_shared<farm::WorkerArguments>();
    CLI::App* command = app.add_subcommand(
        "worker", "Run a worker: render tiles for coordinators on other machines");
    farm::add_worker_options(*command, *arguments);
    return [arguments] { return run_worker(*arguments); };
}

}  // namespace terravox::commands
