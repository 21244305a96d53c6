#pragma once

#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace terravox::cluster {

using Command =
    std::vector<std::string>;  ///< program (looked for in PATH) and arguments; no shell reads them

/// A program that was started; it gets SIGTERM should this one (or the thread that made the object)
/// end without a word. Its status: 0 to 255, or 128 and the signal that ended it. Not thread-safe.
class Child {
public:
    /// What it says goes where this program's goes. @throws Error when it cannot be started
    explicit Child(const Command& command);
    ~Child();  ///< stop()
    Child(const Child&) = delete;
    Child& operator=(const Child&) = delete;

    /// Waits at most this long, or until a signal comes. @return its status; nullopt: it runs
    [[nodiscard]] std::optional<int> wait(std::chrono::milliseconds most);
    /// SIGTERM, and SIGKILL when it has not ended by then. @return its status
    int stop(std::chrono::milliseconds timeout = std::chrono::seconds(10)) noexcept;

private:
    std::string m_name;
    pid_t m_pid = 0;
    std::optional<int> m_status;
};

struct Finished {
    int status = 0;
    std::string out, err;
    /// The first line that it said on standard error, or else its status, for messages.
    [[nodiscard]] std::string reason() const;
};
/// Runs a program to its end, reading nothing. @param folder where it runs; empty: here @throws
/// Error when it cannot be started
[[nodiscard]] Finished run_to_end(const Command& command, const std::filesystem::path& folder = {});

}  // namespace terravox::cluster
