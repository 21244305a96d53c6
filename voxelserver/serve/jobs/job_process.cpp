#include "voxelserver/serve/jobs/job_process.hpp"

#include <fcntl.h>
#include <linux/close_range.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <fstream>
#include <string_view>

#include "common/util/error.hpp"
#include "common/util/text.hpp"

extern char** environ;

namespace terravox::jobs {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kMaxSaid = 4096;
constexpr int kNicer = 10;  ///< than the server
constexpr std::size_t kMaxReason = 300;
constexpr int kUnknownEnd = 127;

/// The limit for files, no higher than that of the server.
rlim_t file_limit(std::uint64_t wanted) {
    rlimit now{};
    if (::getrlimit(RLIMIT_FSIZE, &now) != 0 || now.rlim_max == RLIM_INFINITY)
        return wanted;
    return std::min<rlim_t>(wanted, now.rlim_max);
}

/// Whether a child must not have a variable of the server's: secrets, and proxies, which cannot
/// reach this machine's loopback address.
bool is_withheld(std::string_view name) {
    return name.starts_with("TERRAVOX_SERVER_") || name == "TMPDIR" || name.ends_with("_proxy") ||
           name.ends_with("_PROXY");
}

std::vector<std::string> make_environment(const ProcessStart& start) {
    std::vector<std::string> out;
    for (char** one = environ; *one != nullptr; ++one)
        if (const std::string_view text = *one; !is_withheld(text.substr(0, text.find('='))))
            out.emplace_back(text);
    out.push_back("TMPDIR=" + start.folder.string());
    for (const auto& [name, value] : start.environment)
        out.push_back(name + "=" + value);
    return out;
}

std::vector<char*> pointers_to(const std::vector<std::string>& words) {
    std::vector<char*> out;
    for (const std::string& word : words)
        // For the C interface; nothing is written there.
        out.push_back(const_cast<char*>(word.c_str()));
    out.push_back(nullptr);
    return out;
}

/// Everything that the child needs, made before the fork: after it, a process with threads may call
/// little more than the system.
struct Prepared {
    const char* program;
    const char* folder;
    char* const* arguments;
    char* const* environment;
    rlim_t max_file_bytes;
    pid_t parent;
    int output;
};

/// Runs in the child.
/// @return errno, where the program could not be started
int become(const Prepared& p) noexcept {
    sigset_t none;
    ::sigemptyset(&none);
    const rlimit no_core{0, 0};
    const rlimit file{p.max_file_bytes, p.max_file_bytes};
    // Before the server, whose memory is worth more, the kernel ends this when there is none left.
    if (const int score = ::open("/proc/self/oom_score_adj", O_WRONLY | O_CLOEXEC); score >= 0)
        [[maybe_unused]]
        const ssize_t written = ::write(score, "1000", 4);
    // What libraries have opened without that flag, among it connections of clients.
    (void)::close_range(3, ~0U, CLOSE_RANGE_CLOEXEC);
    const int null = ::open("/dev/null", O_RDONLY | O_CLOEXEC);
    // A courtesy, which a service's filter of system calls may forbid. The kernel ends it at 19.
    [[maybe_unused]]
    const int nice = ::nice(kNicer);
    const bool ready =
        ::prctl(PR_SET_PDEATHSIG, SIGTERM) == 0 && ::getppid() == p.parent &&
        ::setpgid(0, 0) == 0 && ::setrlimit(RLIMIT_CORE, &no_core) == 0 &&
        ::setrlimit(RLIMIT_FSIZE, &file) == 0 && ::chdir(p.folder) == 0 && null >= 0 &&
        ::dup2(null, STDIN_FILENO) >= 0 && ::dup2(p.output, STDOUT_FILENO) >= 0 &&
        ::dup2(p.output, STDERR_FILENO) >= 0 &&
        // Of threads that the server blocks signals in; writing beyond the limit is an error to
        // report, like a full disk.
        ::signal(SIGPIPE, SIG_DFL) != SIG_ERR && ::signal(SIGXFSZ, SIG_IGN) != SIG_ERR &&
        ::sigprocmask(SIG_SETMASK, &none, nullptr) == 0;
    if (ready)
        ::execve(p.program, p.arguments, p.environment);
    return errno;
}

[[noreturn]] void fail_to_start(const ProcessStart& start, int code) {
    throw util::Error("start " + start.program.string() + ": " + std::strerror(code));
}

}  // namespace

JobProcess::JobProcess(const ProcessStart& start) {
    std::vector<std::string> words{start.program.string()};
    words.insert(words.end(), start.words.begin(), start.words.end());
    const std::vector<std::string> variables = make_environment(start);
    const std::vector<char*> argv = pointers_to(words);
    const std::vector<char*> environment = pointers_to(variables);
    const std::string folder = start.folder.string();
    std::array<int, 2> output{};
    if (::pipe2(output.data(), O_CLOEXEC) != 0)
        fail_to_start(start, errno);
    std::array<int, 2> wrong{};  // closed when the program has started, or carries the error
    if (::pipe2(wrong.data(), O_CLOEXEC) != 0) {
        const int code = errno;
        ::close(output[0]);
        ::close(output[1]);
        fail_to_start(start, code);
    }
    const Prepared prepared{words.front().c_str(),
                            folder.c_str(),
                            argv.data(),
                            environment.data(),
                            file_limit(start.max_file_bytes),
                            ::getpid(),
                            output[1]};
    m_pid = ::fork();
    if (m_pid == 0) {
        const int code = become(prepared);
        [[maybe_unused]] const ssize_t reported = ::write(wrong[1], &code, sizeof code);
        ::_exit(127);
    }
    int code = m_pid < 0 ? errno : 0;
    ::close(output[1]);
    ::close(wrong[1]);
    if (m_pid > 0 && ::read(wrong[0], &code, sizeof code) == sizeof code)
        ::waitpid(m_pid, nullptr, 0);
    ::close(wrong[0]);
    if (code != 0) {
        ::close(output[0]);
        fail_to_start(start, code);
    }
    m_output = output[0];
    ::fcntl(m_output, F_SETFL, O_NONBLOCK);
}

JobProcess::~JobProcess() {
    stop();
    ::close(m_output);
}

void JobProcess::read_what_it_says() {
    std::array<char, 4096> part{};
    for (ssize_t n = 0; (n = ::read(m_output, part.data(), part.size())) > 0;) {
        m_said.append(part.data(), static_cast<std::size_t>(n));
        if (m_said.size() > kMaxSaid)
            m_said.erase(0, m_said.size() - kMaxSaid);
    }
}

std::optional<int> JobProcess::look() {
    int raw = 0;
    if (!m_status) {
        const pid_t got = ::waitpid(m_pid, &raw, WNOHANG);
        if (got == m_pid)
            m_status = WIFEXITED(raw) ? WEXITSTATUS(raw) : kSignalled + WTERMSIG(raw);
        else if (got < 0 && errno == ECHILD)
            m_status = kUnknownEnd;  // somebody else has waited for it
    }
    read_what_it_says();
    return m_status;
}

void JobProcess::stop() noexcept {
    if (m_status)
        return;
    constexpr auto kPatience = std::chrono::seconds(5);
    ::kill(-m_pid, SIGTERM);
    const auto end = Clock::now() + kPatience;
    int raw = 0;
    for (pid_t got = 0; (got = ::waitpid(m_pid, &raw, WNOHANG)) != m_pid;) {
        if (got < 0 && errno != EINTR)
            break;
        if (Clock::now() >= end)
            ::kill(-m_pid, SIGKILL);
        ::poll(nullptr, 0, 20);
    }
    m_status = WIFEXITED(raw) ? WEXITSTATUS(raw) : kSignalled + WTERMSIG(raw);
}

std::uint64_t JobProcess::resident_bytes() const {
    std::uint64_t all = 0;
    std::uint64_t resident = 0;
    std::ifstream("/proc/" + std::to_string(m_pid) + "/statm") >> all >> resident;
    return resident * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

std::optional<double> progress_in(const std::string& said) {
    constexpr std::string_view kSign = " %  tile ";
    const std::size_t at = said.rfind(kSign);
    if (at == std::string::npos)
        return std::nullopt;
    int percent = 0;
    int factor = 1;
    for (std::size_t i = at; i > 0 && said[i - 1] >= '0' && said[i - 1] <= '9' && factor <= 100;
         --i) {
        percent += (said[i - 1] - '0') * factor;
        factor *= 10;
    }
    return percent > 100 ? 1 : percent / 100.0;
}

std::string reason_in(const std::string& said) {
    std::size_t end = said.size();
    while (end > 0 && said[end - 1] == '\n')
        --end;
    const std::size_t newline = end == 0 ? std::string::npos : said.rfind('\n', end - 1);
    const std::size_t begin = newline == std::string::npos ? 0 : newline + 1;
    std::string line = said.substr(begin, end - begin);
    constexpr std::string_view kName = "terravox: ";
    if (line.starts_with(kName))
        line.erase(0, kName.size());
    return util::printable(line.substr(0, kMaxReason));
}

}  // namespace terravox::jobs
