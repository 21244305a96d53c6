#pragma once

#include <chrono>
#include <cstddef>

namespace terravox::processors {

/// Measures how many pixels a second a member computes while it has work. Recent seconds count more
/// than earlier ones, so that the estimate adapts to a machine that gets other load. It reads
/// no clock. Not thread-safe.
class SpeedMeter {
public:
    using Time = std::chrono::steady_clock::time_point;

    /// @param has_warm_up  whether the time before the first answer is ignored, as a worker
    /// prepares the picture then
    explicit SpeedMeter(bool has_warm_up) noexcept : m_is_warming_up(has_warm_up) {}

    /// The member has work from now on; nothing changes if it had some already.
    void start(Time now) noexcept;
    /// Counts the time since start() or the last call, if the member has work.
    void advance(Time now) noexcept;
    /// The member has no work any more.
    void stop(Time now) noexcept;
    /// Counts an answer with this many pixels; advance() must have been called before.
    void add_answer(std::size_t pixels) noexcept;

    /// @return 0 while the speed is unknown
    [[nodiscard]] double pixels_per_s() const noexcept;
    [[nodiscard]] bool is_busy() const noexcept { return m_is_busy; }
    /// @return all the time with work, in seconds
    [[nodiscard]] double busy_s(Time now) const noexcept;

private:
    bool m_is_warming_up;
    bool m_is_busy = false;
    Time m_counted_until;  ///< end of the time with work that is counted
    double m_recent_pixels = 0;
    double m_recent_s = 0;
    double m_busy_s = 0;
};

}  // namespace terravox::processors
