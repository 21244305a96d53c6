#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <mutex>

namespace terravox::farm {

/// Measures the latency of a link by its pings: a moving average of the times until their answers.
///
/// A ping has a stamp, its time, which the peer echoes. The peer could echo anything, so the stamps
/// of pings without an answer are kept, and no other stamp counts. Thread-safe; its own mutex is
/// held while nothing else is called.
class LatencyMeter {
public:
    /// Number of pings without an answer that are kept; the oldest are forgotten first.
    static constexpr std::size_t kMaxOutstanding = 64;

    /// To be called before a ping goes out: its answer may arrive before the sender continues.
    /// @param stamp of the ping: the time now, in ns of any steady clock
    void ping_sent(std::uint64_t stamp);
    /// Takes the answer to a ping. Pings that were sent before this one no longer wait for theirs,
    /// since a link keeps the order.
    /// @param stamp  that the peer has echoed
    /// @param now_ns on the clock of the stamps
    /// @return false: no ping with this stamp waits for an answer, and nothing has changed
    bool pong_received(std::uint64_t stamp, std::uint64_t now_ns);
    /// @return average in seconds; 0: no ping was answered yet
    [[nodiscard]] double average_s() const noexcept { return m_average_s; }

private:
    std::mutex m_mutex;
    std::deque<std::uint64_t> m_outstanding;  ///< stamps, oldest first
    std::atomic<double> m_average_s{0};       ///< written with the mutex held
};

}  // namespace terravox::farm
