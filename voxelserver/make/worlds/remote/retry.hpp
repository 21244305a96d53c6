#pragma once

#include <chrono>
#include <optional>

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

/// Why a try for a box failed, where a retry may succeed.
enum class FailureKind {
    kLost,  ///< no complete reply: refused, reset, cut short, silent or too slow
    /// 429, 502, 503, 504: the server, or a proxy before it, has a queue or is starting.
    kBusy,
    kFailed,   ///< 500: mostly permanent, such as a damaged square
    kDamaged,  ///< a reply other than requested: checksum, wrong box, another format
};

/// When to retry for one box, and when to give up. Not thread-safe: one for each request.
///
/// Busy servers are retried until the timeout ends, at the intervals that they request; other
/// failures a few times each. Waits grow and are randomized, so that loaders that failed together
/// do not retry together. Time is passed in by the caller.
class Retry {
public:
    using Clock = std::chrono::steady_clock;
    using Milliseconds = std::chrono::milliseconds;
    static constexpr Milliseconds kLongestWait{60'000};

    /// @param timeout from `now` to the end of the last try
    /// @param is_reachable false: nothing was received for long; only a busy server is tried twice
    Retry(Clock::time_point now, Milliseconds timeout, bool is_reachable = true) noexcept
        : m_end(now + timeout), m_is_reachable(is_reachable) {}

    /// How long the next try may take, at least 1 ms.
    [[nodiscard]] Milliseconds time_left(Clock::time_point now) const noexcept;
    /// After a failed try.
    /// @param retry_after as requested by the server; limited to kLongestWait
    /// @param chance random, [0, 1)
    /// @return how long to wait before the next try; nullopt: give up, now or because the wait
    /// would outlast the timeout
    [[nodiscard]] std::optional<Milliseconds> wait_after(
        FailureKind kind, Clock::time_point now, std::optional<std::chrono::seconds> retry_after,
        double chance) noexcept;
    [[nodiscard]] int tries() const noexcept { return m_tries; }  ///< that failed so far

private:
    Clock::time_point m_end;
    bool m_is_reachable;
    int m_tries = 0;
};

}  // namespace terravox::remote
