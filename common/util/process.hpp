#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace terravox::util {

/// The name of this machine, as it calls itself.
/// @throws Error where the system does not tell
[[nodiscard]] std::string host_name();

/// Program and arguments; they are not interpreted by a shell. The program is searched for in PATH,
/// unless its name contains a slash.
using Command = std::vector<std::string>;

/// Finds a program by its name: in PATH, or at that path if the name contains a slash.
/// @return empty if it is not found
[[nodiscard]] std::filesystem::path find_program(const std::string& name);

/// A child process, without input. Its status: 0 to 255; 128 plus the signal that ended it, as
/// shells have it; 127 where somebody else has waited for it. Not thread-safe.
class Process {
public:
    /// For work that strangers ask for: the process has a lower priority and is the first to end
    /// when memory runs out; it has a process group, but no open files, blocked signals or core
    /// dumps.
    struct Confinement {
        std::uint64_t max_file_bytes = 0;  ///< of each file that it writes
    };
    struct Start {
        Command command;
        std::filesystem::path folder = {};  ///< working directory; empty: that of this process
        std::optional<std::vector<std::string>> environment =
            {};                          ///< NAME=VALUE; nullopt: this one's
        std::filesystem::path log = {};  ///< takes its output on both channels, from its start
        /// Without a log, open files for its output and errors; -1: where this program's go.
        int output = -1;
        int errors = -1;
        std::optional<Confinement> confinement = {};
        /// Else it gets SIGTERM when the thread that made the object ends, however that ends.
        bool may_outlive = false;
    };

    /// @throws Error when it cannot be started, or the log cannot be written
    explicit Process(const Start& start);
    ~Process();  ///< stop()
    Process(const Process&) = delete;
    Process& operator=(const Process&) = delete;

    /// Waits until it ends.
    /// @return its status
    int wait();
    /// The same, at most this long, or until a signal arrives.
    /// @return its status; nullopt: it is still running
    [[nodiscard]] std::optional<int> wait(std::chrono::milliseconds timeout);
    /// Sends SIGTERM, and SIGKILL if it has not ended after the timeout; to its whole group where
    /// it is confined.
    /// @return its status
    int stop(std::chrono::milliseconds timeout = std::chrono::seconds(10)) noexcept;
    /// Leaves it alone from now on: it is neither stopped nor waited for.
    void detach() noexcept { m_status = 0; }
    [[nodiscard]] pid_t id() const noexcept { return m_id; }

private:
    /// @param flags of waitpid(2)
    [[nodiscard]] bool has_ended(int flags) noexcept;
    pid_t m_id = 0;
    pid_t m_signalled = 0;  ///< what kill() takes: its id, or its group
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

}  // namespace terravox::util
