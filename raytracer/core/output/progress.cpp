#include "raytracer/core/output/progress.hpp"

#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>

namespace terravox::output {
namespace {

constexpr double kTerminalEvery_s = 0.1;
constexpr double kPlainEvery_s = 5;

double seconds(std::chrono::steady_clock::duration d) {
    return std::chrono::duration<double>(d).count();
}

}  // namespace

std::string to_time_left(double elapsed_s, double share) {
    if (!(share > 0))
        return "preparing";
    return fmt::format("{:.0f} s left", elapsed_s / share - elapsed_s);
}

Progress::Progress(std::uint64_t total_tiles, std::uint64_t total_pixels, bool quiet, double time_s)
    : m_total_tiles(total_tiles),
      m_total_pixels(total_pixels),
      m_time_s(time_s),
      m_quiet(quiet),
      m_terminal(::isatty(STDERR_FILENO) == 1),
      m_start(std::chrono::steady_clock::now()),
      m_last(m_start) {}

void Progress::tile_done(std::uint64_t pixels, std::uint64_t rays) {
    ++m_tiles;
    m_pixels += pixels;
    m_rays += rays;
}

void Progress::look(const std::function<std::vector<std::string>()>& details) {
    const auto now = std::chrono::steady_clock::now();
    if (m_quiet || seconds(now - m_last) < (m_terminal ? kTerminalEvery_s : kPlainEvery_s))
        return;
    m_last = now;
    if (details)
        m_details = details();
    show(false);
}

void Progress::finish() {
    if (m_shown)
        show(true);
}

// Lines below the bar are written anew each time: the cursor goes back up to the bar's line.
void Progress::erase_details() {
    if (m_below > 0)
        std::fprintf(stderr, "\x1b[%zuA", m_below);
    m_below = 0;
}

void Progress::show(bool last) {
    if (m_quiet)
        return;
    m_shown = true;
    const double elapsed = seconds(std::chrono::steady_clock::now() - m_start);
    const double share = std::min(
        1.0, m_time_s > 0 ? elapsed / m_time_s
                          : static_cast<double>(m_pixels) /
                                static_cast<double>(std::max<std::uint64_t>(m_total_pixels, 1)));
    const std::string left = to_time_left(elapsed, share);
    const auto tiles = static_cast<unsigned long long>(m_tiles);
    const auto total = static_cast<unsigned long long>(m_total_tiles);
    std::string rate;
    if (m_rays > 0)
        rate = fmt::format("  {:.2f} Mray/s",
                           static_cast<double>(m_rays) / 1e6 / (elapsed > 0 ? elapsed : 1));
    if (m_terminal) {
        constexpr int kWidth = 32;
        std::string bar(kWidth, '.');
        for (int i = 0; i < static_cast<int>(share * kWidth) && i < kWidth; ++i)
            bar[static_cast<std::size_t>(i)] = '#';
        erase_details();
        std::fprintf(stderr, "\r[%s] %3.0f %%  tile %llu of %llu%s  %s \x1b[K%s", bar.c_str(),
                     share * 100, tiles, total, rate.c_str(), left.c_str(),
                     last && m_details.empty() ? "\n" : "");
        for (const std::string& line : m_details)
            std::fprintf(stderr, "\n%s\x1b[K", line.c_str());
        m_below = m_details.size();
        if (m_below > 0)
            std::fprintf(stderr, "\x1b[J%s", last ? "\n" : "");  // there may have been more lines
    } else {
        std::fprintf(stderr, "%3.0f %%  tile %llu of %llu%s  %s\n", share * 100, tiles, total,
                     rate.c_str(), left.c_str());
        for (const std::string& line : m_details)
            std::fprintf(stderr, "%s\n", line.c_str());
    }
    std::fflush(stderr);
}

}  // namespace terravox::output
