#include <arpa/inet.h>
#include <netinet/in.h>
#include <signal.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

#include "common/thread/stop.hpp"
#include "common/util/process.hpp"
#include "common/util/secret.hpp"
#include "common/util/text.hpp"
#include "raytracer/farm/cluster/slurm_run.hpp"

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

util::Error pool_error(const std::string& what) {
    return util::Error("render with workers of Slurm: " + what);
}

/// Jobs that are cancelled with their owner, however it ends.
class OwnJobs {
public:
    OwnJobs(const Slurm& slurm, const JobFolder& folder) : m_slurm(slurm), m_folder(folder) {}
    ~OwnJobs() {
        if (const std::string wrong = m_slurm.cancel(jobs); !wrong.empty())
            std::fprintf(stderr, "terravox: cancel the jobs: %s; look at squeue --me\n",
                         wrong.c_str());
    }
    OwnJobs(const OwnJobs&) = delete;
    OwnJobs& operator=(const OwnJobs&) = delete;
    void submit(const std::string& script, const std::vector<std::string>& options) {
        jobs.push_back(m_slurm.submit(m_folder.path(), script, options));
    }
    std::vector<Slurm::JobId> jobs;

private:
    const Slurm& m_slurm;
    const JobFolder& m_folder;
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
    Pool(const SlurmOptions& options, const JobFolder& folder, JobCommand render,
         std::optional<int> threads)
        : m_options(options),
          m_folder(folder),
          m_render(std::move(render)),
          m_renders_itself(options.coordinator_in_job || threads.value_or(0) > 0) {
        // The submitting machine does not render unless its user requests it.
        if (!threads && !options.coordinator_in_job)
            m_render.add({"--threads", "0"});
        if (!threads && options.coordinator_in_job && options.needs.cpus > 0)
            m_render.add({"--threads", std::to_string(options.needs.cpus)});
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
        Command command = m_render.with_program(m_folder.program());
        command.insert(command.end(), {"--token-file", token_file().string()});
        // On all interfaces: a machine's own name often means its loopback to itself.
        if (!m_options.coordinator_in_job)
            command.insert(command.end(), {"--listen", ":" + std::to_string(m_port)});
        return command;
    }

    void write_scripts() const {
        std::string address;
        if (m_options.coordinator_in_job)
            m_folder.write_script(
                "coordinator", SlurmJob::kOnce,
                {"coordinator",
                 {{"command", coordinator()},
                  {"host", m_options.address.empty() ? Value::plain("\"$HOSTNAME\"")
                                                     : Value(m_options.address)},
                  {"address_file", address_file().string()}}});
        else
            address = (m_options.address.empty() ? util::host_name() : m_options.address) + ":" +
                      std::to_string(m_port);
        m_folder.write_script("pool", SlurmJob::kArray,
                              worker_body(m_folder.program(), m_options.needs,
                                          token_file().string(), address, address_file().string()),
                              "worker");
    }

    util::ExitCode say() const {
        std::printf("cd %s\n", util::shell_word(m_folder.path().string()).c_str());
        if (m_options.coordinator_in_job) {
            std::printf(
                "sbatch coordinator.sbatch\nsbatch %s --dependency=after:COORDINATOR pool.sbatch\n",
                array_option().c_str());
            return util::ExitCode::kDone;
        }
        std::printf("sbatch %s pool.sbatch\n", array_option().c_str());
        std::string line;
        for (const std::string& word : coordinator())
            line += (line.empty() ? "" : " ") + util::shell_word(word);
        std::printf("%s\n", line.c_str());
        return util::ExitCode::kDone;
    }

    util::ExitCode run_here(const Slurm& slurm, const std::stop_token& stop) const {
        OwnJobs own(slurm, m_folder);
        util::Process child({.command = coordinator()});
        own.submit("pool.sbatch", {array_option()});
        say_jobs(own.jobs);
        QueueWatch watch(slurm, own.jobs, m_options.nodes, m_options.quiet);
        for (auto next = Clock::now();;) {
            if (const auto status = child.wait(std::chrono::milliseconds(200)))
                return to_code(*status);
            if (stop.stop_requested()) {
                child.stop();
                throw pool_error(
                    "interrupted by a signal; the picture is not finished, the workers are "
                    "cancelled");
            }
            if (Clock::now() < next)
                continue;
            next = Clock::now() + std::chrono::seconds(m_options.poll_s);
            if (watch.look() >= 2 && !m_renders_itself) {
                child.stop();
                throw pool_error("all workers ended before the picture was finished; see " +
                                 m_folder.logs());
            }
        }
    }

    util::ExitCode run_job(const Slurm& slurm, const std::stop_token& stop) const {
        std::error_code ignored;
        fs::remove(address_file(), ignored);
        OwnJobs own(slurm, m_folder);
        own.submit("coordinator.sbatch", {});
        const Slurm::JobId coordinator = own.jobs.front();
        own.submit("pool.sbatch", {array_option(), "--dependency=after:" + coordinator});
        say_jobs(own.jobs);
        QueueWatch all(slurm, own.jobs, m_options.nodes + 1, m_options.quiet);
        QueueWatch first(slurm, {coordinator}, 1, true);
        while (true) {
            (void)all.look();
            if (const auto code = slurm.exit_code(coordinator)) {
                if (*code != 0)
                    std::fprintf(stderr,
                                 "terravox: the coordinator's job ended with %d; see "
                                 "%s/coordinator-%s.txt\n",
                                 *code, m_folder.logs().c_str(), coordinator.c_str());
                return to_code(*code);
            }
            if (first.look() >= 3)
                throw pool_error("the coordinator's job " + coordinator +
                                 " is over, and Slurm no longer reports how it ended; see " +
                                 m_folder.logs());
            if (thread::wait_for_stop(stop, std::chrono::seconds(m_options.poll_s)))
                throw pool_error(
                    "interrupted by a signal; the picture is not finished, all jobs are cancelled");
        }
    }

    void say_jobs(const std::vector<Slurm::JobId>& jobs) const {
        if (m_options.quiet)
            return;
        for (const Slurm::JobId& job : jobs)
            std::fprintf(stderr, "slurm: job %s\n", job.c_str());
    }

    const SlurmOptions& m_options;
    const JobFolder& m_folder;
    JobCommand m_render;
    bool m_renders_itself;
    int m_port = 0;
};

}  // namespace

util::ExitCode run_pool(const SlurmOptions& options, const JobFolder& folder, JobCommand render,
                        std::optional<int> threads) {
    return Pool(options, folder, std::move(render), threads).run();
}

}  // namespace terravox::cluster
