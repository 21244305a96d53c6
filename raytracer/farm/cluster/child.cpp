#include "raytracer/farm/cluster/child.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

#include "common/util/error.hpp"
#include "common/util/files.hpp"
#include "raytracer/core/animate/video.hpp"

extern char** environ;

namespace terravox::cluster {
namespace {

using Clock = std::chrono::steady_clock;

int find_status(int raw) noexcept {
    return WIFEXITED(raw) ? WEXITSTATUS(raw) : 128 + WTERMSIG(raw);
}

/// An unnamed file for a program's output: unlike a pipe it never fills up.
class Spool {
public:
    Spool() : m_file(::memfd_create("terravox-said", MFD_CLOEXEC)) {
        if (m_file < 0)
            throw util::Error(
                std::string("start a program: cannot create a file in memory for its output: ") +
                std::strerror(errno));
    }
    ~Spool() { ::close(m_file); }
    Spool(const Spool&) = delete;
    Spool& operator=(const Spool&) = delete;
    [[nodiscard]] int file() const noexcept { return m_file; }
    [[nodiscard]] std::string text() const {
        std::string out;
        std::array<char, 65536> part{};
        for (ssize_t n = 0;
             (n = ::pread(m_file, part.data(), part.size(), static_cast<off_t>(out.size()))) > 0;)
            out.append(part.data(), static_cast<std::size_t>(n));
        return out;
    }

private:
    int m_file;
};

class FileActions {
public:
    FileActions() { ::posix_spawn_file_actions_init(&m_actions); }
    ~FileActions() { ::posix_spawn_file_actions_destroy(&m_actions); }
    FileActions(const FileActions&) = delete;
    FileActions& operator=(const FileActions&) = delete;
    [[nodiscard]] posix_spawn_file_actions_t* get() noexcept { return &m_actions; }

private:
    posix_spawn_file_actions_t m_actions{};
};

std::vector<char*> list_arguments(const Command& command) {
    std::vector<char*> argv;
    for (const std::string& word : command)
        // For the C interface; nothing is written there.
        argv.push_back(const_cast<char*>(word.c_str()));
    argv.push_back(nullptr);
    return argv;
}

pid_t start(const Command& command, FileActions& actions) {
    const std::vector<char*> argv = list_arguments(command);
    pid_t child = 0;
    if (const int failed =
            ::posix_spawnp(&child, argv[0], actions.get(), nullptr, argv.data(), environ);
        failed != 0)
        throw util::Error("start " + command.front() + ": " + std::strerror(failed));
    return child;
}

/// A file descriptor that is closed at the end.
class OpenFile {
public:
    explicit OpenFile(int file) : m_file(file) {}
    ~OpenFile() {
        if (m_file >= 0)
            ::close(m_file);
    }
    OpenFile(const OpenFile&) = delete;
    OpenFile& operator=(const OpenFile&) = delete;
    [[nodiscard]] int get() const noexcept { return m_file; }

private:
    int m_file;
};

int open_log(const std::filesystem::path& log) {
    if (log.empty())
        return -1;
    return util::open_to_write(log, O_WRONLY | O_CREAT | O_TRUNC, 0644, "write " + log.string());
}

}  // namespace

Child::Child(const Command& command, const std::filesystem::path& log) : m_name(command.front()) {
    const std::string program = animate::find_program(command.front()).string();
    if (program.empty())
        throw util::Error("start " + m_name + ": there is no such program");
    const std::vector<char*> argv = list_arguments(command);
    const OpenFile output(open_log(log));
    std::array<int, 2> wrong{};  // closed when the program has started, or carries the error
    if (::pipe2(wrong.data(), O_CLOEXEC) != 0)
        throw util::Error("start " + m_name + ": " + std::strerror(errno));
    const pid_t parent = ::getpid();
    m_pid = ::fork();
    if (m_pid == 0) {
        // posix_spawn cannot set this: the child ends with this program, however that ends.
        const int null = ::open("/dev/null",
                                O_RDONLY | O_CLOEXEC);  // terminal input is for this program
        if (::prctl(PR_SET_PDEATHSIG, SIGTERM) == 0 && ::getppid() == parent && null >= 0 &&
            ::dup2(null, STDIN_FILENO) >= 0 &&
            (output.get() < 0 || (::dup2(output.get(), STDOUT_FILENO) >= 0 &&
                                  ::dup2(output.get(), STDERR_FILENO) >= 0)))
            ::execv(program.c_str(), argv.data());
        const int code = errno;
        [[maybe_unused]] const ssize_t reported = ::write(wrong[1], &code, sizeof code);
        ::_exit(127);
    }
    int code = m_pid < 0 ? errno : 0;
    ::close(wrong[1]);
    if (m_pid > 0 && ::read(wrong[0], &code, sizeof code) == sizeof code)
        ::waitpid(m_pid, nullptr, 0);
    ::close(wrong[0]);
    if (code != 0)
        throw util::Error("start " + m_name + ": " + std::strerror(code));
}

Child::~Child() {
    stop();
}

std::optional<int> Child::wait(std::chrono::milliseconds timeout) {
    const auto end = Clock::now() + timeout;
    while (!m_status) {
        int raw = 0;
        const pid_t got = ::waitpid(m_pid, &raw, WNOHANG);
        if (got == m_pid)
            m_status = find_status(raw);
        else if (got < 0 && errno != EINTR)
            throw util::Error("wait for " + m_name + ": " + std::strerror(errno));
        else {
            const auto left =
                std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now());
            if (left.count() <= 0)
                break;
            constexpr std::chrono::milliseconds kLook{50};
            if (::poll(nullptr, 0, static_cast<int>(std::min(left, kLook).count())) < 0)
                break;
        }
    }
    return m_status;
}

int Child::stop(std::chrono::milliseconds timeout) noexcept {
    if (m_status)
        return *m_status;
    ::kill(m_pid, SIGTERM);
    const auto end = Clock::now() + timeout;
    int raw = 0;
    for (pid_t got = 0; (got = ::waitpid(m_pid, &raw, WNOHANG)) != m_pid;) {
        if (got < 0 && errno != EINTR)
            break;
        if (Clock::now() >= end)
            ::kill(m_pid, SIGKILL);
        ::poll(nullptr, 0, 20);
    }
    m_status = find_status(raw);
    return *m_status;
}

std::string Finished::reason() const {
    const std::string line = err.substr(0, err.find('\n'));
    return line.empty() ? "status " + std::to_string(status) : line;
}

Finished run_to_end(const Command& command, const std::filesystem::path& folder) {
    const Spool out;
    const Spool err;
    FileActions actions;
    ::posix_spawn_file_actions_addopen(actions.get(), STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    ::posix_spawn_file_actions_adddup2(actions.get(), out.file(), STDOUT_FILENO);
    ::posix_spawn_file_actions_adddup2(actions.get(), err.file(), STDERR_FILENO);
    if (!folder.empty())
        ::posix_spawn_file_actions_addchdir_np(actions.get(), folder.c_str());
    const pid_t child = start(command, actions);
    int raw = 0;
    while (::waitpid(child, &raw, 0) < 0)
        if (errno != EINTR)
            throw util::Error("wait for " + command.front() + ": " + std::strerror(errno));
    return {find_status(raw), out.text(), err.text()};
}

}  // namespace terravox::cluster
