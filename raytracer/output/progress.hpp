#pragma once

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <string>

namespace terravox {

/// Tells a person how far a picture is: a bar with tiles, rays per second and time left on a terminal, a plain line now and then
/// elsewhere. Writes to standard error. Not thread-safe.
class Progress {
public:
    /// @param total_pixels the unit of progress @param quiet say nothing @param time_s above 0: the picture ends by time, which is the progress then
    Progress(std::uint64_t total_tiles, std::uint64_t total_pixels, bool quiet, double time_s = 0);
    void tile_done(std::uint64_t pixels, std::uint64_t rays);
    void finish();  ///< ends the bar's line

private:
    void show(bool last);
    std::uint64_t m_total_tiles, m_total_pixels, m_tiles = 0, m_pixels = 0, m_rays = 0;
    double m_time_s;
    bool m_quiet, m_terminal, m_shown = false;
    std::chrono::steady_clock::time_point m_start, m_last;
};

}  // namespace terravox
