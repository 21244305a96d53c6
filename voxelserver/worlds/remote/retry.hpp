#pragma once

#include <chrono>
#include <optional>

namespace terravox::remote {

/// Why a try for a box failed, where another try may fare better.
enum class Trouble {
    kLost,     ///< no whole reply: refused, reset, cut short, silent or too slow
    kBusy,     ///< 429, 502, 503, 504: the server, or what stands before it, works off a queue or
               ///< starts
    kFailed,   ///< 500: mostly for good, as a damaged square is
    kDamaged,  ///< a reply that is not what was asked for: checksum, wrong box, another format
};

/// When to try again for one box, and when to give it up. Not thread-safe: one for each request.
///
/// OverloadedError servers are tried until the timeout ends, as often as they ask; other troubles
/// a few times each. Waits grow and are spread at random, so that loaders that failed together do
/// not come back together. Time comes from outside.
class Retry {
public:
    using Clock = std::chrono::steady_clock;
    using Milliseconds = std::chrono::milliseconds;
    static constexpr Milliseconds kLongestWait{60'000};

    /// @param timeout from `now` to the end of the last try @param hopeful false: nothing has come
    /// for long; only a busy server is tried twice
    Retry(Clock::time_point now, Milliseconds timeout, bool is_reachable = true) noexcept
        : m_end(now + timeout), m_is_reachable(is_reachable) {}

    /// How long the next try may take, at least 1 ms.
    [[nodiscard]] Milliseconds time_left(Clock::time_point now) const noexcept;
    /// After a failed try. @param retry_after what the server asks for; up to kLongestWait counts
    /// @param chance random, [0, 1)
    /// @return how long to wait before the next try; nullopt: give up, now or because the wait
    /// would outlast the timeout
    [[nodiscard]] std::optional<Milliseconds> wait_after(
        Trouble trouble, Clock::time_point now, std::optional<std::chrono::seconds> retry_after,
        double chance) noexcept;
    [[nodiscard]] int tries() const noexcept { return m_tries; }  ///< that failed so far

private:
    Clock::time_point m_end;
    bool m_is_reachable;
    int m_tries = 0;
};

}  // namespace terravox::remote
