#include "common/util/process.hpp"

#include <fcntl.h>
#include <linux/close_range.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <sstream>

#include "common/util/error.hpp"
#include "common/util/files.hpp"

extern char** environ;

namespace terravox::util {
namespace {

constexpr int kUnknownEnd = 127;
constexpr int kNicer = 10;  ///< than this process

int to_status(int raw) noexcept {
    return WIFEXITED(raw) ? WEXITSTATUS(raw) : 128 + WTERMSIG(raw);
}

std::vector<char*> pointers_to(const std::vector<std::string>& words) {
    std::vector<char*> out;
    for (const std::string& word : words)
        // For the C interface; nothing is written there.
        out.push_back(const_cast<char*>(word.c_str()));
    out.push_back(nullptr);
    return out;
}

/// The limit for files, no higher than that of this process.
rlim_t file_limit(std::uint64_t wanted) {
    rlimit now{};
    if (::getrlimit(RLIMIT_FSIZE, &now) != 0 || now.rlim_max == RLIM_INFINITY)
        return wanted;
    return std::min<rlim_t>(wanted, now.rlim_max);
}

/// Everything that the child needs, made before it exists: a child of a process with threads may
/// call little more than the system.
struct Prepared {
    const char* program;
    char* const* arguments;
    char* const* environment;
    const char* folder;  ///< nullptr: stays
    int output;          ///< -1: stays
    int errors;
    bool is_confined;
    bool may_outlive;
    rlim_t max_file_bytes;
    pid_t parent;
    sigset_t mask;
    int wrong;  ///< takes errno where the program cannot be started
};

bool confine(const Prepared& p) noexcept {
    const rlimit no_core{0, 0};
    const rlimit file{p.max_file_bytes, p.max_file_bytes};
    // Before its parent, whose memory is worth more, the kernel ends this when there is none left.
    if (const int score = ::open("/proc/self/oom_score_adj", O_WRONLY | O_CLOEXEC); score >= 0)
        [[maybe_unused]]
        const ssize_t written = ::write(score, "1000", 4);
    // What libraries have opened without that flag, among it connections of clients.
    (void)::close_range(3, ~0U, CLOSE_RANGE_CLOEXEC);
    // A courtesy, which a service's filter of system calls may forbid. The kernel ends it at 19.
    [[maybe_unused]]
    const int nice = ::nice(kNicer);
    // Writing beyond the limit is an error to report, like a full disk.
    return ::setpgid(0, 0) == 0 && ::setrlimit(RLIMIT_CORE, &no_core) == 0 &&
           ::setrlimit(RLIMIT_FSIZE, &file) == 0 && ::signal(SIGPIPE, SIG_DFL) != SIG_ERR &&
           ::signal(SIGXFSZ, SIG_IGN) != SIG_ERR;
}

/// Handlers work on the memory of the parent.
void drop_handlers() noexcept {
    for (int number = 1; number < NSIG; ++number) {
        struct sigaction action{};
        if (::sigaction(number, nullptr, &action) == 0 && action.sa_handler != SIG_IGN)
            ::signal(number, SIG_DFL);
    }
}

bool get_ready(const Prepared& p) noexcept {
    drop_handlers();
    const int null = ::open("/dev/null", O_RDONLY | O_CLOEXEC);
    return (p.may_outlive ||
            (::prctl(PR_SET_PDEATHSIG, SIGTERM) == 0 && ::getppid() == p.parent)) &&
           (!p.is_confined || confine(p)) && (p.folder == nullptr || ::chdir(p.folder) == 0) &&
           null >= 0 && ::dup2(null, STDIN_FILENO) >= 0 &&
           (p.output < 0 || ::dup2(p.output, STDOUT_FILENO) >= 0) &&
           (p.errors < 0 || ::dup2(p.errors, STDERR_FILENO) >= 0) &&
           ::sigprocmask(SIG_SETMASK, &p.mask, nullptr) == 0;
}

[[noreturn]] void become(const Prepared& p) noexcept {
    if (get_ready(p))
        ::execve(p.program, p.arguments, p.environment);
    const int code = errno;
    [[maybe_unused]] const ssize_t reported = ::write(p.wrong, &code, sizeof code);
    ::_exit(kUnknownEnd);
}

/// The child borrows this process's memory until it has become the program: to copy the tables of
/// its pages could take more memory than there is left. posix_spawn() does so too, but knows
/// neither limits nor the end of the parent.
pid_t make_child(const Prepared& p) noexcept {
    const pid_t child = ::vfork();  // NOLINT(clang-analyzer-security.insecureAPI.vfork)
    if (child == 0)
        become(p);
    return child;
}

/// An unnamed file for a program's output: unlike a pipe it never fills up.
class Spool {
public:
    Spool() : m_file(::memfd_create("terravox-said", MFD_CLOEXEC)) {
        if (m_file.get() < 0)
            throw Error(
                std::string("start a program: cannot create a file in memory for its output: ") +
                std::strerror(errno));
    }
    [[nodiscard]] int file() const noexcept { return m_file.get(); }
    [[nodiscard]] std::string text() const {
        std::string out;
        std::array<char, 65536> part{};
        for (ssize_t n = 0; (n = ::pread(m_file.get(), part.data(), part.size(),
                                         static_cast<off_t>(out.size()))) > 0;)
            out.append(part.data(), static_cast<std::size_t>(n));
        return out;
    }

private:
    Descriptor m_file;
};

}  // namespace

std::string host_name() {
    std::array<char, 256> name{};
    if (::gethostname(name.data(), name.size() - 1) != 0)
        throw Error(std::string("get this machine's name: ") + std::strerror(errno));
    return name.data();
}

std::filesystem::path find_program(const std::string& name) {
    const auto runs = [](const std::filesystem::path& file) {
        std::error_code ignored;
        return std::filesystem::is_regular_file(file, ignored) && ::access(file.c_str(), X_OK) == 0;
    };
    if (name.find('/') != std::string::npos)
        return runs(name) ? std::filesystem::path(name) : std::filesystem::path();
    const char* path = std::getenv("PATH");
    std::istringstream folders(path != nullptr ? path : "");
    for (std::string folder; std::getline(folders, folder, ':');)
        if (!folder.empty() && runs(std::filesystem::path(folder) / name))
            return std::filesystem::path(folder) / name;
    return {};
}

Process::Process(const Start& start) {
    const std::string& name = start.command.front();
    const auto failed = [&](int code) { return Error("start {}: {}", name, std::strerror(code)); };
    const std::string program =
        name.find('/') != std::string::npos ? name : find_program(name).string();
    if (program.empty())
        throw failed(ENOENT);
    const std::vector<char*> arguments = pointers_to(start.command);
    const std::vector<char*> environment =
        start.environment ? pointers_to(*start.environment) : std::vector<char*>();
    const Descriptor log(start.log.empty() ? -1
                                           : open_to_write(start.log, O_WRONLY | O_CREAT | O_TRUNC,
                                                           0644, "write " + start.log.string()));
    Pipe wrong = open_pipe("start " + name);  // closed by a start, or carries the error
    Prepared prepared{
        .program = program.c_str(),
        .arguments = arguments.data(),
        .environment = start.environment ? environment.data() : environ,
        .folder = start.folder.empty() ? nullptr : start.folder.c_str(),
        .output = log.get() < 0 ? start.output : log.get(),
        .errors = log.get() < 0 ? start.errors : log.get(),
        .is_confined = start.confinement.has_value(),
        .may_outlive = start.may_outlive,
        .max_file_bytes = start.confinement ? file_limit(start.confinement->max_file_bytes) : 0,
        .parent = ::getpid(),
        .mask = {},
        .wrong = wrong.writing.get()};
    sigset_t all;
    sigset_t before;
    ::sigfillset(&all);
    ::pthread_sigmask(SIG_SETMASK, &all, &before);
    // Of threads that block signals: a confined process can be ended by them.
    if (prepared.is_confined)
        ::sigemptyset(&prepared.mask);
    else
        prepared.mask = before;
    m_id = make_child(prepared);
    int code = m_id < 0 ? errno : 0;
    ::pthread_sigmask(SIG_SETMASK, &before, nullptr);
    wrong.writing.close();
    if (m_id > 0 && ::read(wrong.reading.get(), &code, sizeof code) == sizeof code)
        ::waitpid(m_id, nullptr, 0);
    if (code != 0)
        throw failed(code);
    m_signalled = prepared.is_confined ? -m_id : m_id;
}

Process::~Process() {
    stop();
}

bool Process::has_ended(int flags) noexcept {
    if (m_status)
        return true;
    int raw = 0;
    const pid_t got = ::waitpid(m_id, &raw, flags);
    if (got == m_id)
        m_status = to_status(raw);
    else if (got < 0 && errno != EINTR)
        m_status = kUnknownEnd;
    return m_status.has_value();
}

int Process::wait() {
    while (!has_ended(0)) {
    }
    return *m_status;
}

std::optional<int> Process::wait(std::chrono::milliseconds timeout) {
    using Clock = std::chrono::steady_clock;
    const auto end = Clock::now() + timeout;
    while (!has_ended(WNOHANG)) {
        const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now());
        constexpr std::chrono::milliseconds kLook{50};
        if (left.count() <= 0 ||
            ::poll(nullptr, 0, static_cast<int>(std::min(left, kLook).count())) < 0)
            break;
    }
    return m_status;
}

int Process::stop(std::chrono::milliseconds timeout) noexcept {
    if (m_status)
        return *m_status;
    ::kill(m_signalled, SIGTERM);
    const auto end = std::chrono::steady_clock::now() + timeout;
    while (!has_ended(WNOHANG)) {
        if (std::chrono::steady_clock::now() >= end)
            ::kill(m_signalled, SIGKILL);
        ::poll(nullptr, 0, 20);
    }
    return *m_status;
}

std::string Finished::reason() const {
    const std::string line = err.substr(0, err.find('\n'));
    return line.empty() ? "status " + std::to_string(status) : line;
}

Finished run_to_end(const Command& command, const std::filesystem::path& folder) {
    const Spool out;
    const Spool err;
    Process process({.command = command,
                     .folder = folder,
                     .output = out.file(),
                     .errors = err.file(),
                     .may_outlive = true});
    const int status = process.wait();
    return {status, out.text(), err.text()};
}

}  // namespace terravox::util
