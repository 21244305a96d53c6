#pragma once

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <string>
#include <vector>

namespace terravox::output {

/// The words for the time that a picture still takes, by the share of it that is finished. Until a
/// first tile is, nothing is known: its boxes are being made or fetched.
/// @param share [0, 1]
[[nodiscard]] std::string to_time_left(double elapsed_s, double share);

/// Reports the progress of a picture: on a terminal as a bar with tiles, time left and, where
/// there are rays, how many a second; elsewhere as an occasional plain line. Writes to standard
/// error. Not thread-safe.
class Progress {
public:
    /// @param total_pixels the unit of progress
    /// @param quiet print nothing
    /// @param time_s above 0: the picture ends after this time, which is then the measure of
    /// progress
    Progress(std::uint64_t total_tiles, std::uint64_t total_pixels, bool quiet, double time_s = 0);
    void tile_done(std::uint64_t pixels, std::uint64_t rays);
    /// Removes tiles and pixels that need not be rendered from the total.
    void leave_out(std::uint64_t tiles, std::uint64_t pixels) noexcept {
        m_total_tiles -= tiles;
        m_total_pixels -= pixels;
    }
    /// Prints the progress if an update is due, with more lines below.
    /// @param details empty: no more lines
    void look(const std::function<std::vector<std::string>()>& details);
    [[nodiscard]] std::uint64_t total_tiles() const noexcept { return m_total_tiles; }
    void finish();  ///< ends the bar's line

private:
    void show(bool last);
    void erase_details();
    std::uint64_t m_total_tiles;
    std::uint64_t m_total_pixels;
    std::uint64_t m_tiles = 0;
    std::uint64_t m_pixels = 0;
    std::uint64_t m_rays = 0;
    double m_time_s;
    bool m_quiet;
    bool m_terminal;
    bool m_shown = false;
    std::chrono::steady_clock::time_point m_start;
    std::chrono::steady_clock::time_point m_last;
    std::vector<std::string> m_details;
    std::size_t m_below = 0;  ///< lines of details printed below the bar
};

}  // namespace terravox::output
