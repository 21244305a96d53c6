#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace terravox::bench {

/// How a program ended and what it took.
struct ChildOutcome {
    int exit_code = 0;  ///< 128 + signal when a signal ended it; 127 when it could not be started
    double wall_s = 0;  ///< from before the fork to after its end was seen
    double user_s = 0;
    double system_s = 0;
    std::int64_t peak_kib = 0;  ///< peak resident memory of the largest process in its tree
};

/// Runs programs one after the other and measures each.
///
/// A program started by a process that has used much memory inherits that peak in its own accounts:
/// Linux hands the peak on over fork and exec. So a helper is forked while this process is still
/// small, and it starts the programs. Make one at the start of main, before any thread. Requests
/// and replies are packets on a pair of sockets; the helper ends when its end is closed. Not
/// thread-safe.
class ChildRunner {
public:
    /// @throws Error when the helper cannot be started
    ChildRunner();
    ~ChildRunner();
    ChildRunner(const ChildRunner&) = delete;
    ChildRunner& operator=(const ChildRunner&) = delete;

    /// Runs a program to its end. @param command program (looked up in PATH without a slash) and
    /// arguments, none with a NUL byte
    /// @param output file that takes its output on both channels, from its start @throws Error
    /// when the helper is gone
    [[nodiscard]] ChildOutcome run(const std::vector<std::string>& command,
                                   const std::filesystem::path& output);
    /// User and system time of all programs run so far, seconds.
    [[nodiscard]] double cpu_s() const noexcept { return m_cpu_s; }

private:
    int m_socket = -1;
    int m_helper = -1;
    double m_cpu_s = 0;
};

/// The last line of a program's output that is not empty, for messages.
[[nodiscard]] std::string last_line(const std::filesystem::path& output);

}  // namespace terravox::bench
