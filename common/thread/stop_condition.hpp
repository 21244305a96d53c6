#pragma once

#include <chrono>
#include <stop_token>
#include <utility>

namespace terravox::thread {

/// Whether running work must stop: when a stop is requested on either of two tokens, or at a
/// deadline.
class StopCondition {
public:
    using Clock = std::chrono::steady_clock;
    /// A default-constructed token, which has no source, never requests a stop.
    explicit StopCondition(std::stop_token first, std::stop_token second = {},
                           Clock::time_point deadline = Clock::time_point::max()) noexcept
        : m_first(std::move(first)), m_second(std::move(second)), m_deadline(deadline) {}
    [[nodiscard]] bool is_met() const noexcept {
        return m_first.stop_requested() || m_second.stop_requested() ||
               (m_deadline != Clock::time_point::max() && Clock::now() >= m_deadline);
    }

private:
    std::stop_token m_first;
    std::stop_token m_second;
    Clock::time_point m_deadline;
};

}  // namespace terravox::thread
