#pragma once

#include <chrono>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <utility>
#include <vector>

namespace terravox::preview {

[[nodiscard]] inline double seconds(std::chrono::steady_clock::duration duration) noexcept {
    return std::chrono::duration<double>(duration).count();
}

[[nodiscard]] inline std::chrono::steady_clock::duration to_duration(double seconds) noexcept {
    return std::chrono::duration_cast<std::chrono::steady_clock::duration>(
        std::chrono::duration<double>(seconds));
}

/// Statistics of the window's frame times, for the report.
class FrameTimes {
public:
    /// Adds the time of a frame in which there was something to do.
    void frame(double seconds) { note(m_frames, seconds); }
    /// Adds the time from a change until each shown pixel is of the new picture.
    void first_picture(double seconds) { note(m_firsts, seconds); }
    /// Adds the time that cancelling the previous picture took.
    void stop(double seconds) { note(m_stops, seconds); }
    /// Moving average of the frame time.
    [[nodiscard]] double frame_s() const noexcept { return m_recent_s; }

    [[nodiscard]] nlohmann::json report() const;

private:
    void note(std::vector<float>& to, double seconds);
    std::vector<float> m_frames;
    std::vector<float> m_firsts;
    std::vector<float> m_stops;
    double m_recent_s = 0;
};

/// What the window has to do between two frames.
enum class Activity : std::uint8_t {
    kIdle,       ///< nothing changes before the next input
    kAnimated,   ///< the display changes from frame to frame
    kComputing,  ///< a picture is in progress, and uses all available time
};

/// Decides how long a frame waits for input, and how long it traces, for 60 frames a second and an
/// idle machine when there is nothing to do. Used by one thread.
class FramePacer {
public:
    using Clock = std::chrono::steady_clock;

    explicit FramePacer(Clock::time_point now) : m_began(now) {}

    /// @return the longest time to wait for input before the next frame
    [[nodiscard]] static double wait_s(Activity activity) noexcept;

    /// Begins a frame, after waiting.
    /// @param waiting_since when the waiting began
    /// @param wait_s maximum time to wait
    /// @return seconds since the previous frame began
    double begin(Clock::time_point waiting_since, double wait_s, bool had_input,
                 Clock::time_point now) noexcept;
    [[nodiscard]] Clock::time_point began() const noexcept { return m_began; }
    /// Whether there was input a few frames ago: windows of Dear ImGui need some frames to adapt
    /// their size to new contents.
    [[nodiscard]] bool is_settling() const noexcept { return m_settling > 0; }

    /// @param drawn when the panels of this frame were drawn
    /// @return when tracing should stop
    [[nodiscard]] Clock::time_point work_until(Clock::time_point drawn) const noexcept;
    /// Ends a frame, which is shown now.
    /// @param drawn when its panels were drawn
    /// @param traced when tracing stopped
    void end(Clock::time_point drawn, Clock::time_point traced, Clock::time_point now) noexcept;
    /// @param rests nothing changes from now on before the next input
    /// @return whether that is so for the first time
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
