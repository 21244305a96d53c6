#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <limits>

namespace terravox::preview {

/// Decides when a probe layer (is_probe) is made again because boxes were not in memory: soon while
/// more of them are loaded each time, and at growing intervals while none are. Used by one thread.
class ProbeRetry {
public:
    using Clock = std::chrono::steady_clock;

    /// To be called for another scene or layer, of whose boxes nothing is known.
    void reset() noexcept {
        m_wait = kMin;
        m_missing = std::numeric_limits<std::size_t>::max();
    }
    void begin(Clock::time_point now) noexcept { m_began = now; }
    [[nodiscard]] bool is_due(Clock::time_point now) const noexcept {
        return now - m_began >= m_wait;
    }
    /// To be called when the layer is made again.
    /// @param missing number of boxes that the last probes did not find
    void note(std::size_t missing) noexcept {
        m_wait = missing < m_missing ? kMin : std::min(2 * m_wait, kMax);
        m_missing = missing;
    }
    static constexpr std::chrono::milliseconds kMin{500};
    static constexpr std::chrono::milliseconds kMax{16'000};

private:
    Clock::time_point m_began;
    std::chrono::milliseconds m_wait = kMin;
    std::size_t m_missing = std::numeric_limits<std::size_t>::max();
};

}  // namespace terravox::preview
