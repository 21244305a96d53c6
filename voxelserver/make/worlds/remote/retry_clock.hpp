#pragma once

#include <chrono>

namespace terravox::remote {

/// The clock for deadlines of retries and for the waits between two tries. The default is the
/// steady clock. Tests substitute a clock that advances by a wait without sleeping. Thread-safe.
class RetryClock {
public:
    using Steady = std::chrono::steady_clock;

    RetryClock() = default;
    virtual ~RetryClock() = default;
    RetryClock(const RetryClock&) = delete;
    RetryClock& operator=(const RetryClock&) = delete;

    [[nodiscard]] virtual Steady::time_point now() const noexcept { return Steady::now(); }
    /// Called where a wait begins.
    /// @return how much of it has to pass in real time
    [[nodiscard]] virtual std::chrono::milliseconds begin_wait(
        std::chrono::milliseconds time) noexcept {
        return time;
    }

    /// The clock of programs. It lives until the program ends.
    [[nodiscard]] static RetryClock& steady() noexcept {
        static RetryClock clock;
        return clock;
    }
};

}  // namespace terravox::remote
