#pragma once

#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace terravox::cluster {

/// Program (searched for in PATH) and arguments; they are not interpreted by a shell.
using Command = std::vector<std::string>;

/// A child process. It gets SIGTERM if this process (or the thread that made the object) ends
/// without stopping it. Its status: 0 to 255, or 128 plus the signal that ended it. Not
/// thread-safe.
class Child {
public:
    /// @param log file that takes its output on both channels, from its start; empty: it goes where
    /// this program's goes
    /// @throws Error when it cannot be started, or the log cannot be written
    explicit Child(const Command& command, const std::filesystem::path& log = {});
    ~Child();  ///< stop()
    Child(const Child&) = delete;
    Child& operator=(const Child&) = delete;

    /// Waits until the child ends, at most this long, or until a signal arrives.
    /// @return its status; nullopt: it is still running
    [[nodiscard]] std::optional<int> wait(std::chrono::milliseconds timeout);
    /// Sends SIGTERM, and SIGKILL if it has not ended after the timeout.
    /// @return its status
    int stop(std::chrono::milliseconds timeout = std::chrono::seconds(10)) noexcept;

private:
    std::string m_name;
    pid_t m_pid = 0;
    std::optional<int> m_status;
};

struct Finished {
    int status = 0;
    std::string out;
    std::string err;
    /// The first line of its standard error, or else its status, for messages.
    [[nodiscard]] std::string reason() const;
};
/// Runs a program to its end without input.
/// @param folder working directory; empty: the current one
/// @throws Error when it cannot be started
[[nodiscard]] Finished run_to_end(const Command& command, const std::filesystem::path& folder = {});

}  // namespace terravox::cluster
