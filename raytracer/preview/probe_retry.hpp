#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <limits>

namespace terravox::preview {

/// When a layer of walks is to be probed again for boxes that were not in memory: soon while more
/// of them are loaded each time, and at growing intervals where none are. Used by one thread.
class ProbeRetry {
public:
    using Clock = std::chrono::steady_clock;

    /// Another scene or layer: nothing is known of its boxes.
    void reset() noexcept {
        m_wait = kMin;
        m_missing = std::numeric_limits<std::size_t>::max();
    }
    void begin(Clock::time_point now) noexcept { m_began = now; }
    [[nodiscard]] bool is_due(Clock::time_point now) const noexcept {
        return now - m_began >= m_wait;
    }
    /// It is probed again. @param missing boxes that the last probes did not find
    void note(std::size_t missing) noexcept {
        m_wait = missing < m_missing ? kMin : std::min(2 * m_wait, kMax);
        m_missing = missing;
    }

    static constexpr std::chrono::milliseconds kMin{500}, kMax{16'000};

private:
    Clock::time_point m_began;
    std::chrono::milliseconds m_wait = kMin;
    std::size_t m_missing = std::numeric_limits<std::size_t>::max();
};

}  // namespace terravox::preview
