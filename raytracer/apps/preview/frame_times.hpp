#pragma once

#include <nlohmann/json_fwd.hpp>

#include <cstdint>
#include <vector>

namespace terravox::preview {

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

}  // namespace terravox::preview
