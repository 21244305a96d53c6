#pragma once

#include <nlohmann/json_fwd.hpp>

#include <cstdint>
#include <vector>

namespace terravox::preview {

/// How smooth the window was: what the report says of it.
class FrameTimes {
public:
    void frame(double seconds) {
        note(m_frames, seconds);
    }  ///< of a frame in which there was something to do
    void first_picture(double seconds) {
        note(m_firsts, seconds);
    }  ///< from a change until each pixel is of the new picture, as shown
    void stop(double seconds) { note(m_stops, seconds); }  ///< that ending the picture before took
    [[nodiscard]] double frame_s() const noexcept { return m_recent_s; }  ///< lately

    [[nodiscard]] nlohmann::json report() const;

private:
    void note(std::vector<float>& to, double seconds);
    std::vector<float> m_frames, m_firsts, m_stops;
    double m_recent_s = 0;
};

}  // namespace terravox::preview
