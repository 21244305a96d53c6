#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <optional>

#include "common/thread/stop.hpp"
#include "common/util/process.hpp"
#include "common/util/secret.hpp"
#include "common/util/text.hpp"
#include "raytracer/apps/commands/cluster/job.hpp"

namespace terravox::cluster {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

/// Finds a port that is free now on all interfaces. If it is taken meanwhile, the coordinator
/// reports it.
int free_port() {
    const int socket = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    socklen_t length = sizeof address;
    const bool found = socket >= 0 &&
                       ::bind(socket, reinterpret_cast<const sockaddr*>(&address), length) == 0 &&
                       ::getsockname(socket, reinterpret_cast<sockaddr*>(&address), &length) == 0;
    const int code = errno;
    if (socket >= 0)
        ::close(socket);
    if (!found)
        throw util::Error(std::string("look for a free port: ") + std::strerror(code));
    return ntohs(address.sin_port);
}

util::ExitCode to_code(int status) {
    return status >= 0 && status <= 3 ? static_cast<util::ExitCode>(status)
                                      : util::ExitCode::kFailed;
}

/// Jobs that are cancelled with their owner, however it ends.
class OwnJobs {
public:
    explicit OwnJobs(const Slurm& slurm) : m_slurm(slurm) {}
    ~OwnJobs() {
        if (const std::string wrong = m_slurm.cancel(jobs); !wrong.empty())
            std::fprintf(stderr, "terravox: cancel the jobs: %s; look at squeue --me\n",
                         wrong.c_str());
    }
    OwnJobs(const OwnJobs&) = delete;
    OwnJobs& operator=(const OwnJobs&) = delete;
    std::vector<Slurm::JobId> jobs;

private:
    const Slurm& m_slurm;
};

/// The secret of one run; removed with it.
class TokenFile {
public:
    explicit TokenFile(const JobFolder& folder) : m_file(folder.path() / "token") {
        folder.write_secret("token", util::make_token() + "\n");
    }
    ~TokenFile() {
        std::error_code ignored;
        fs::remove(m_file, ignored);
    }
    TokenFile(const TokenFile&) = delete;
    TokenFile& operator=(const TokenFile&) = delete;

private:
    fs::path m_file;
};

/// Follows one run. The coordinator is a child of this process, or a job.
class Pool {
public:
    Pool(const SlurmOptions& options, ForwardedArguments render)
        : m_options(options),
          m_render(std::move(render)),
          m_folder(options, fs::path(m_render.outputs.front()).stem().string()) {
        const scene::Scene scene = m_render.base_scene();
        // The submitting machine does not render unless its user requests it.
        if (!scene.processing.threads && !options.coordinator_in_job)
            m_render.words.insert(m_render.words.end(), {"--threads", "0"});
        if (!scene.processing.threads && options.coordinator_in_job && options.needs.cpus > 0)
            m_render.words.insert(m_render.words.end(),
                                  {"--threads", std::to_string(options.needs.cpus)});
        m_renders_itself = options.coordinator_in_job || scene.processing.threads.value_or(0) > 0;
        if (!options.coordinator_in_job)
            m_port = options.port > 0 ? options.port : free_port();
    }

    util::ExitCode run() {
        write_scripts();
        if (m_options.dry_run)
            return say();
        const Slurm slurm;
        const thread::StopSignals signals(
            thread::StopSignals::Options{{SIGINT, SIGTERM, SIGHUP}, false, {}});
        const TokenFile token(m_folder);
        return m_options.coordinator_in_job ? run_job(slurm, signals.token())
                                            : run_here(slurm, signals.token());
    }

private:
    [[nodiscard]] fs::path token_file() const { return m_folder.path() / "token"; }
    [[nodiscard]] fs::path address_file() const { return m_folder.path() / "address"; }
    [[nodiscard]] std::string array_option() const {
        return "--array=0-" + std::to_string(m_options.nodes - 1);
    }

    [[nodiscard]] Command coordinator() const {
        Command command{m_folder.place().program.string()};
        const std::vector<std::string> beginning = words_of_command(m_render.command);
        command.insert(command.end(), beginning.begin(), beginning.end());
        command.insert(command.end(), m_render.words.begin(), m_render.words.end());
        command.insert(command.end(), {"--token-file", token_file().string()});
        // On all interfaces: a machine's own name often means its loopback to itself.
        if (!m_options.coordinator_in_job)
            command.insert(command.end(), {"--listen", ":" + std::to_string(m_port)});
        return command;
    }

    void write_scripts() const {
        PoolScript pool{"", address_file(), token_file()};
        if (m_options.coordinator_in_job)
            m_folder.write_script("coordinator.sbatch",
                                  coordinator_script(m_folder.place(), coordinator(),
                                                     m_options.address, address_file()));
        else
            pool.address = (m_options.address.empty() ? util::host_name() : m_options.address) +
                           ":" + std::to_string(m_port);
        m_folder.write_script("pool.sbatch", pool_script(m_folder.place(), pool));
    }

    util::ExitCode say() const {
        std::printf("cd %s\n", util::shell_word(m_folder.path().string()).c_str());
        if (m_options.coordinator_in_job)
            std::printf(
                "sbatch coordinator.sbatch\nsbatch %s --dependency=after:COORDINATOR pool.sbatch\n",
                array_option().c_str());
        else {
            std::printf("sbatch %s pool.sbatch\n", array_option().c_str());
            std::string line;
            for (const std::string& word : coordinator())
                line += (line.empty() ? "" : " ") + util::shell_word(word);
            std::printf("%s\n", line.c_str());
        }
        return util::ExitCode::kDone;
    }

    util::ExitCode run_here(const Slurm& slurm, const std::stop_token& stop) {
        OwnJobs own(slurm);
        util::Process child({.command = coordinator()});
        own.jobs.push_back(slurm.submit(m_folder.path(), "pool.sbatch", {array_option()}));
        said(own.jobs);
        QueueReporter reporter(m_options.nodes, m_options.quiet);
        int empty_looks = 0;
        for (auto next = Clock::now();;) {
            if (const auto status = child.wait(std::chrono::milliseconds(200)))
                return to_code(*status);
            if (stop.stop_requested()) {
                child.stop();
                throw util::Error(
                    "render with workers of Slurm: interrupted by a signal; the picture is not "
                    "finished, the workers are cancelled");
            }
            if (Clock::now() < next)
                continue;
            next = Clock::now() + std::chrono::seconds(m_options.poll_s);
            const auto counts = slurm.counts(own.jobs);
            if (!counts)
                continue;
            reporter.report(*counts);
            // Twice, so that a controller that is restarting is not trusted at once.
            empty_looks = counts->all() == 0 ? empty_looks + 1 : 0;
            if (empty_looks == 2 && !m_renders_itself) {
                child.stop();
                throw no_workers();
            }
        }
    }

    util::ExitCode run_job(const Slurm& slurm, const std::stop_token& stop) {
        std::error_code ignored;
        fs::remove(address_file(), ignored);
        OwnJobs own(slurm);
        own.jobs.push_back(slurm.submit(m_folder.path(), "coordinator.sbatch", {}));
        const Slurm::JobId coordinator = own.jobs.front();
        own.jobs.push_back(slurm.submit(m_folder.path(), "pool.sbatch",
                                        {array_option(), "--dependency=after:" + coordinator}));
        said(own.jobs);
        QueueReporter reporter(m_options.nodes + 1, m_options.quiet);
        for (int empty_looks = 0;;) {
            if (const auto counts = slurm.counts(own.jobs))
                reporter.report(*counts);
            if (const auto code = slurm.exit_code(coordinator)) {
                if (*code != 0)
                    std::fprintf(
                        stderr, "terravox: the coordinator's job ended with %d; see %s\n", *code,
                        (m_folder.path() / "logs" / ("coordinator-" + coordinator + ".txt"))
                            .c_str());
                return to_code(*code);
            }
            const auto left = slurm.counts({coordinator});
            empty_looks = left && left->all() == 0 ? empty_looks + 1 : 0;
            if (empty_looks == 3)
                throw util::Error("render with workers of Slurm: the coordinator's job " +
                                  coordinator +
                                  " is over, and Slurm no longer reports how it ended; see " +
                                  (m_folder.path() / "logs").string());
            if (thread::wait_for_stop(stop, std::chrono::seconds(m_options.poll_s)))
                throw util::Error(
                    "render with workers of Slurm: interrupted by a signal; the picture is not "
                    "finished, all jobs are cancelled");
        }
    }

    void said(const std::vector<Slurm::JobId>& jobs) const {
        if (m_options.quiet)
            return;
        for (const Slurm::JobId& job : jobs)
            std::fprintf(stderr, "slurm: job %s\n", job.c_str());
    }

    [[nodiscard]] util::Error no_workers() const {
        return util::Error(
            "render with workers of Slurm: all workers ended before the picture was finished; "
            "see " +
            (m_folder.path() / "logs").string());
    }

    SlurmOptions m_options;
    ForwardedArguments m_render;
    JobFolder m_folder;
    bool m_renders_itself = false;
    int m_port = 0;
};

}  // namespace

util::ExitCode run_pool(const SlurmOptions& options, const std::vector<std::string>& words) {
    const std::string& command = options.analyse.empty() ? "render" : options.analyse;
    ForwardedArguments render = ForwardedArguments::read(command, words);
    for (const char* own : {"--listen", "--token-file", "--tls-ca", "--tls-cert", "--tls-key"})
        if (render.has(own))
            throw util::UsageError(std::string("cluster slurm: ") + own +
                                   " among the arguments of " + command +
                                   "; allowed: without it, each run has a token of its own; --port "
                                   "and --address of cluster slurm say where it listens");
    return Pool(options, std::move(render)).run();
}

}  // namespace terravox::cluster
