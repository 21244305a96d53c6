#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

namespace terravox::processors {

/// Watches how long a pool has been without members: when to warn, and when to give up. It reads no
/// clock. Not thread-safe.
class AbsenceWatchdog {
public:
    using Time = std::chrono::steady_clock::time_point;
    using Duration = std::chrono::steady_clock::duration;
    enum class Alarm : std::uint8_t {
        kNone,
        kWarn,
        kTimeout,
    };

    /// A pool begins without members.
    /// @param timeout  how long to wait without members; nullopt: forever
    AbsenceWatchdog(std::optional<Duration> timeout, Time now) noexcept
        : m_timeout(timeout), m_absent_since(now), m_warned(now) {}

    /// There is at least one member.
    void set_present() noexcept { m_absent = false; }
    /// The last member has left, so the wait begins anew.
    void set_absent(Time now) noexcept;

    /// To be called regularly while there is work.
    /// @return kWarn at most every ten seconds; kTimeout always once the timeout has passed
    [[nodiscard]] Alarm poll(Time now) noexcept;
    /// @return the time since the last member left
    [[nodiscard]] Duration absent_for(Time now) const noexcept { return now - m_absent_since; }

private:
    std::optional<Duration> m_timeout;
    bool m_absent = true;
    Time m_absent_since;
    std::optional<Time> m_warned;
};

}  // namespace terravox::processors
