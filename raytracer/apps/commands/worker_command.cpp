#include "raytracer/apps/commands/worker_command.hpp"

#include <CLI/CLI.hpp>

#include <cstdio>
#include <memory>
#include <sstream>

#include "common/thread/parallel.hpp"
#include "common/thread/stop_signals.hpp"
#include "common/util/build_id.hpp"
#include "common/util/log.hpp"
#include "common/util/open_files.hpp"
#include "common/util/resident_memory.hpp"
#include "common/util/secret.hpp"
#include "common/util/version.hpp"
#include "raytracer/farm/worker/metrics_page.hpp"
#include "raytracer/farm/worker/worker_config.hpp"
#include "raytracer/farm/worker/worker_daemon.hpp"

namespace terravox::commands {
namespace {

void set_up_log(const farm::WorkerConfig& config) {
    util::set_up_log(config.log, config.log_json ? util::LogFormat::kJson : util::LogFormat::kText);
}

/// Without credentials, a daemon that only listens makes a token and prints it for use by
/// coordinators.
net::Credentials credentials_or_new(const farm::WorkerConfig& config) {
    if (!config.tls_ca.empty() || !config.join.empty() ||
        !util::find_token(config.token_file, util::kFarmTokenVariable).empty())
        return farm::credentials_of(config);
    net::Credentials out;
    out.token = util::make_token();
    std::fprintf(stderr,
                 "token: %s\ncoordinators render here with: TERRAVOX_FARM_TOKEN=TOKEN terravox "
                 "render --worker HOST:%u ...\n",
                 out.token.c_str(), static_cast<unsigned>(config.listen->port));
    return out;
}

farm::WorkerDaemonOptions options_of(const farm::WorkerConfig& config) {
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

farm::WorkerMetrics metrics_of(const farm::WorkerDaemon& daemon) {
    const farm::WorkerDaemon::Totals t = daemon.totals();
    farm::WorkerMetrics out;
    out.uptime_s = t.uptime_s;
    out.tiles = t.tiles;
    out.pixels = t.pixels;
    out.rays = t.rays;
    out.failed = t.failed;
    out.result_bytes = t.result_bytes;
    out.box_requests = t.box_requests;
    out.busy_s = t.busy_s;
    out.all_sessions = t.sessions;
    out.threads = t.threads;
    out.refused = {{"busy", t.busy}, {"unfit", t.unfit}};
    out.sessions = static_cast<int>(t.now.size());
    out.memory_bytes = util::resident_bytes();
    out.box_limit_bytes = t.memory_bytes;
    out.draining = t.ending;
    for (const farm::WorkerSession::Status& s : t.now) {
        out.box_bytes += s.box_bytes;
        out.waiting += s.waiting;
        out.begun += s.begun;
    }
    return out;
}

std::string joined(const std::vector<std::string>& names) {
    std::string out;
    for (const std::string& name : names)
        out += (out.empty() ? "" : ", ") + name;
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
            m_daemon.reload(options_of(m_running));
            util::log_info("configuration read again; changed: {}",
                           change.now.empty() ? "nothing" : joined(change.now));
            if (!change.restart.empty())
                util::log_warn("after a restart only: {}", joined(change.restart));
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
    farm::WorkerDaemonOptions options = options_of(config);
    options.http = farm::http_access_of(config);
    options.credentials = credentials_or_new(config);
    farm::WorkerDaemon daemon(std::move(options));
    std::unique_ptr<farm::MetricsPage> page;
    if (config.metrics) {
        page = std::make_unique<farm::MetricsPage>(metrics_address(config),
                                                   [&daemon] { return metrics_of(daemon); });
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
