#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string>

namespace terravox::exports {

/// Reports the progress of a conversion: a bar on a terminal, an occasional plain line elsewhere.
/// Writes to standard error. Thread-safe.
class Meter {
public:
    /// @param what text before the bar
    /// @param total steps
    /// @param quiet print nothing
    /// @param told called for each step with what is done and all there is, one call at a time
    Meter(std::string what, std::uint64_t total, bool quiet,
          std::function<void(std::uint64_t, std::uint64_t)> told = {});
    ~Meter() { finish(); }
    Meter(const Meter&) = delete;
    Meter& operator=(const Meter&) = delete;
    void add(std::uint64_t steps = 1);
    void finish();  ///< ends the bar's line; idempotent

private:
    void show(bool last);
    const std::string m_what;
    const std::uint64_t m_total;
    const bool m_quiet;
    const bool m_terminal;
    const std::function<void(std::uint64_t, std::uint64_t)> m_told;
    std::mutex m_mutex;
    std::uint64_t m_done = 0;
    bool m_shown = false;
    bool m_finished = false;
    const std::chrono::steady_clock::time_point m_start;
    std::chrono::steady_clock::time_point m_last;
};

}  // namespace terravox::exports
