#pragma once

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstring>
#include <exception>
#include <string>

#include "common/util/error.hpp"

namespace terravox::test {

/// A sanitizer keeps terabytes of addresses for its own use: under a limit on addresses it could
/// not start.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool kSanitized = true;
#else
inline constexpr bool kSanitized = false;
#endif

/// How a piece of work in a child process ended.
struct Outcome {
    enum class Kind { kDone, kError, kOther, kCrashed };
    Kind kind = Kind::kCrashed;
    std::string text;  ///< what was thrown, or the signal
};

/// Runs work in a child with limits on memory (but with sanitizers) and time, so that a crash or a
/// hang of it is a result and not the end of the tests. The process must have no other threads.
template <class Work>
Outcome in_child(const Work& work, rlim_t memory_bytes = rlim_t{1} << 30, rlim_t cpu_s = 20) {
    int ends[2];
    if (::pipe(ends) != 0)
        return {Outcome::Kind::kOther, "no pipe"};
    const pid_t child = ::fork();
    if (child == 0) {
        const rlimit memory{memory_bytes, memory_bytes};
        const rlimit cpu{cpu_s, cpu_s};
        const rlimit core{0, 0};
        if (!kSanitized)
            ::setrlimit(RLIMIT_AS, &memory);
        ::setrlimit(RLIMIT_CPU, &cpu);
        ::setrlimit(RLIMIT_CORE, &core);
        for (const int fatal : {SIGSEGV, SIGABRT, SIGFPE, SIGBUS, SIGILL, SIGTERM})
            std::signal(fatal, SIG_DFL);  // the test framework's stay in the parent
        ::alarm(60);
        std::string said;
        try {
            work();
            said = "D";
        } catch (const util::Error& e) {
            said = std::string("E") + e.what();
        } catch (const std::exception& e) {
            said = std::string("O") + e.what();
        } catch (...) {
            said = "Osomething that is no exception";
        }
        said.resize(std::min<std::size_t>(said.size(), 4000));
        const ssize_t written = ::write(ends[1], said.data(), said.size());
        ::_exit(written == static_cast<ssize_t>(said.size()) ? 0 : 9);
    }
    ::close(ends[1]);
    std::string said(4096, '\0');
    std::size_t used = 0;
    for (ssize_t n = 0; (n = ::read(ends[0], said.data() + used, said.size() - used)) > 0;)
        used += static_cast<std::size_t>(n);
    ::close(ends[0]);
    said.resize(used);
    int status = 0;
    ::waitpid(child, &status, 0);
    if (WIFSIGNALED(status))
        return {Outcome::Kind::kCrashed, "signal " + std::to_string(WTERMSIG(status)) + " (" +
                                             ::strsignal(WTERMSIG(status)) + ")"};
    if (said.empty())
        return {Outcome::Kind::kCrashed, "exit code " + std::to_string(WEXITSTATUS(status))};
    return {said[0] == 'D'   ? Outcome::Kind::kDone
            : said[0] == 'E' ? Outcome::Kind::kError
                             : Outcome::Kind::kOther,
            said.substr(1)};
}

/// What is wrong with work that may end well, or in an Error of one line that names `name`; ""
/// when nothing is.
inline std::string complaint(const Outcome& outcome, const std::string& name = "") {
    if (outcome.kind == Outcome::Kind::kDone)
        return {};
    if (outcome.kind != Outcome::Kind::kError)
        return "no Error: " + outcome.text;
    if (outcome.text.find(name) == std::string::npos)
        return "the message does not name " + name + ": " + outcome.text;
    return outcome.text.find('\n') == std::string::npos ? "" : "several lines: " + outcome.text;
}

}  // namespace terravox::test
