#pragma once

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <string>
#include <vector>

namespace terravox::output {

/// Tells a person how far a picture is: a bar with tiles, rays per second and time left on a
/// terminal, a plain line now and then elsewhere. Writes to standard error. Not thread-safe.
class Progress {
public:
    /// @param total_pixels the unit of progress @param quiet say nothing @param time_s above 0: the
    /// picture ends by time, which is the progress then
    Progress(std::uint64_t total_tiles, std::uint64_t total_pixels, bool quiet, double time_s = 0);
    void tile_done(std::uint64_t pixels, std::uint64_t rays);
    /// So many need not be done.
    void leave_out(std::uint64_t tiles, std::uint64_t pixels) noexcept {
        m_total_tiles -= tiles;
        m_total_pixels -= pixels;
    }
    /// Shows how far it is if the time has come, with more lines below. @param details none:
    /// nothing more
    void look(const std::function<std::vector<std::string>()>& details);
    [[nodiscard]] std::uint64_t total_tiles() const noexcept { return m_total_tiles; }
    void finish();  ///< ends the bar's line

private:
    void show(bool last);
    void erase_details();
    std::uint64_t m_total_tiles, m_total_pixels, m_tiles = 0, m_pixels = 0, m_rays = 0;
    double m_time_s;
    bool m_quiet, m_terminal, m_shown = false;
    std::chrono::steady_clock::time_point m_start, m_last;
    std::vector<std::string> m_details;
    std::size_t m_below = 0;  ///< lines of details that stand below the bar
};

}  // namespace terravox::output
