#pragma once

#include <chrono>
#include <cstdint>
#include <utility>

namespace terravox::preview {

/// What goes on in the window between two frames.
enum class Activity : std::uint8_t {
    kIdle,       ///< nothing changes before the next input
    kAnimated,   ///< what is seen changes from frame to frame
    kComputing,  ///< a picture is in progress, and needs all the time there is
};

/// How long a frame waits for input, and how long it traces: so that frames follow one another at
/// 60 a second, and the machine rests when nothing is to be done. Used by one thread.
class FramePacer {
public:
    using Clock = std::chrono::steady_clock;

    explicit FramePacer(Clock::time_point now) : m_began(now) {}

    /// @return the longest time to wait for input before the next frame
    [[nodiscard]] static double wait_s(Activity activity) noexcept;

    /// A frame begins after waiting. @param waiting_since when the waiting began @param wait_s how
    /// long it might last @return seconds since the frame before began
    double begin(Clock::time_point waiting_since, double wait_s, bool had_input,
                 Clock::time_point now) noexcept;
    [[nodiscard]] Clock::time_point began() const noexcept { return m_began; }
    /// Whether input came a few frames ago: windows of Dear ImGui need some frames until they have
    /// the size that suits what is new in them.
    [[nodiscard]] bool is_settling() const noexcept { return m_settling > 0; }

    /// @param drawn when the panels of this frame were drawn @return when tracing should stop
    [[nodiscard]] Clock::time_point work_until(Clock::time_point drawn) const noexcept;
    /// The frame is shown. @param drawn, traced when panels were drawn, and when tracing stopped
    void end(Clock::time_point drawn, Clock::time_point traced, Clock::time_point now) noexcept;
    /// @param rests nothing changes from now on before the next input @return it did before
    [[nodiscard]] bool comes_to_rest(bool rests) noexcept {
        return !std::exchange(m_rests, rests) && rests;
    }

private:
    Clock::time_point m_began;
    int m_settling = 0;          ///< frames that still follow one another after input
    double m_drawing_s = 0.004;  ///< share of a frame that is not tracing: a moving average
    bool m_rests = false;
};

}  // namespace terravox::preview
