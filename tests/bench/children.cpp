#include "tests/bench/children.hpp"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <fstream>

#include "common/util/error.hpp"

namespace terravox::bench {
namespace {

constexpr std::size_t kMaxRequest_bytes = 64 * 1024;
constexpr int kNotStarted = 127;

double seconds(const timeval& t) noexcept {
    return static_cast<double>(t.tv_sec) + static_cast<double>(t.tv_usec) * 1e-6;
}

/// A request: the output file, then the command, each ended by a NUL byte.
std::vector<char*> list_texts(char* begin, const char* end) {
    std::vector<char*> out;
    for (char* at = begin; at < end; at += std::strlen(at) + 1)
        out.push_back(at);
    return out;
}

[[noreturn]] void become(const char* output, char** command) {
    std::signal(SIGINT, SIG_DFL);
    const int file = ::open(output, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
    if (file >= 0 && ::dup2(file, STDOUT_FILENO) >= 0 && ::dup2(file, STDERR_FILENO) >= 0) {
        ::execvp(command[0], command);
        ::dprintf(STDERR_FILENO, "start %s: %s\n", command[0], std::strerror(errno));
    }
    ::_exit(kNotStarted);
}

ChildOutcome start_and_wait(const char* output, char** command) {
    ChildOutcome out;
    const auto start = std::chrono::steady_clock::now();
    const pid_t child = ::fork();
    if (child == 0)
        become(output, command);
    int status = 0;
    rusage used{};
    pid_t ended = child;
    do {
        if (child > 0)
            ended = ::wait4(child, &status, 0, &used);
    } while (ended < 0 && errno == EINTR && child > 0);
    out.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    out.exit_code = ended < 0             ? kNotStarted
                    : WIFSIGNALED(status) ? 128 + WTERMSIG(status)
                                          : WEXITSTATUS(status);
    out.user_s = seconds(used.ru_utime);
    out.system_s = seconds(used.ru_stime);
    out.peak_kib = used.ru_maxrss;
    return out;
}

/// The helper's life: a request, a program, a reply, until the other side is gone.
[[noreturn]] void serve(int socket) {
    std::signal(SIGINT, SIG_IGN);  // the program gets its own; its end is still to be reported
    std::array<char, kMaxRequest_bytes> request{};
    while (true) {
        const ssize_t bytes = ::recv(socket, request.data(), request.size(), 0);
        if (bytes < 0 && errno == EINTR)
            continue;
        if (bytes <= 0)
            ::_exit(0);
        auto texts = list_texts(request.data(), request.data() + bytes);
        texts.push_back(nullptr);
        const ChildOutcome outcome = start_and_wait(texts[0], &texts[1]);
        if (::send(socket, &outcome, sizeof outcome, MSG_NOSIGNAL) != sizeof outcome)
            ::_exit(1);
    }
}

}  // namespace

ChildRunner::ChildRunner() {
    int pair[2];
    if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, pair) != 0)
        throw util::Error(std::string("start the helper: ") + std::strerror(errno));
    m_helper = ::fork();
    if (m_helper == 0) {
        ::close(pair[0]);
        serve(pair[1]);
    }
    ::close(pair[1]);
    m_socket = pair[0];
    if (m_helper < 0) {
        ::close(m_socket);
        throw util::Error(std::string("start the helper: ") + std::strerror(errno));
    }
}

ChildRunner::~ChildRunner() {
    ::close(m_socket);
    while (::waitpid(m_helper, nullptr, 0) < 0 && errno == EINTR) {
    }
}

ChildOutcome ChildRunner::run(const std::vector<std::string>& command,
                              const std::filesystem::path& output) {
    std::string request = output.string() + '\0';
    for (const std::string& text : command)
        request += text + '\0';
    if (request.size() > kMaxRequest_bytes)
        throw util::Error("run " + command.front() + ": " + std::to_string(request.size()) +
                          " bytes of arguments; allowed: " + std::to_string(kMaxRequest_bytes));
    ChildOutcome out;
    ssize_t got = -1;
    if (::send(m_socket, request.data(), request.size(), MSG_NOSIGNAL) ==
        static_cast<ssize_t>(request.size())) {
        do
            got = ::recv(m_socket, &out, sizeof out, 0);
        while (got < 0 && errno == EINTR);
    }
    if (got != sizeof out)
        throw util::Error("run " + command.front() + ": the helper that starts programs is gone");
    m_cpu_s += out.user_s + out.system_s;
    return out;
}

std::string last_line(const std::filesystem::path& output) {
    std::ifstream file(output);
    std::string line;
    std::string last;
    while (std::getline(file, line))
        if (!line.empty())
            last = line;
    return last;
}

}  // namespace terravox::bench
