#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

namespace terravox::processors {

/// Watches how long a pool has been without members: when to warn, and when to give up. The time
/// adds up until a member answers: members that come and go again without a result do not prolong
/// the wait. It reads no clock. Not thread-safe.
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

    /// There is at least one member. Idempotent.
    void set_present(Time now) noexcept;
    /// The last member has left. Idempotent.
    void set_absent(Time now) noexcept;
    /// A member has sent a result, so the next wait begins anew.
    void set_answered() noexcept;

    /// To be called regularly while there is work.
    /// @return kWarn at most every ten seconds; kTimeout always once the timeout has passed, while
    /// there is no member
    [[nodiscard]] Alarm poll(Time now) noexcept;
    /// @return the time without members since the last result, or since the beginning
    [[nodiscard]] Duration absent_for(Time now) const noexcept;

private:
    std::optional<Duration> m_timeout;
    Duration m_absent_before{};  ///< in earlier stretches since the last result
    std::optional<Time> m_absent_since;
    std::optional<Time> m_warned;
};

}  // namespace terravox::processors
