#pragma once

namespace terravox::cluster {

/// While it lives, SIGINT, SIGTERM and SIGHUP are noted instead of ending the program. One at a
/// time.
class StopSignals {
public:
    StopSignals();
    ~StopSignals();
    StopSignals(const StopSignals&) = delete;
    StopSignals& operator=(const StopSignals&) = delete;
    /// Whether one came since this was made.
    [[nodiscard]] static bool came() noexcept;
    /// Waits; a signal ends it early. @return came()
    static bool wait_ms(int max_ms) noexcept;
};

}  // namespace terravox::cluster
