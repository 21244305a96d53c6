#include "voxelserver/out/export/core/meter.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <utility>

namespace terravox::exports {
namespace {

constexpr double kTerminalEvery_s = 0.1;
constexpr double kPlainEvery_s = 5;

double seconds(std::chrono::steady_clock::duration d) {
    return std::chrono::duration<double>(d).count();
}

}  // namespace

Meter::Meter(std::string what, std::uint64_t total, bool quiet,
             std::function<void(std::uint64_t, std::uint64_t)> told)
    : m_what(std::move(what)),
      m_total(total),
      m_quiet(quiet),
      m_terminal(::isatty(STDERR_FILENO) == 1),
      m_told(std::move(told)),
      m_start(std::chrono::steady_clock::now()),
      m_last(m_start) {}

void Meter::add(std::uint64_t steps) {
    const std::lock_guard lock(m_mutex);
    m_done += steps;
    if (m_told)
        m_told(m_done, m_total);
    const auto now = std::chrono::steady_clock::now();
    if (m_finished || seconds(now - m_last) < (m_terminal ? kTerminalEvery_s : kPlainEvery_s))
        return;
    m_last = now;
    show(false);
}

void Meter::finish() {
    const std::lock_guard lock(m_mutex);
    if (m_shown && !m_finished)
        show(true);
    m_finished = true;
}

void Meter::show(bool last) {
    if (m_quiet)
        return;
    m_shown = true;
    const double share =
        m_total == 0 ? 1
                     : std::min(1.0, static_cast<double>(m_done) / static_cast<double>(m_total));
    const double elapsed = seconds(std::chrono::steady_clock::now() - m_start);
    const double left = share > 0 ? elapsed / share - elapsed : 0;
    if (m_terminal) {
        constexpr int kWidth = 32;
        std::string bar(kWidth, '.');
        std::fill_n(bar.begin(), static_cast<std::ptrdiff_t>(share * kWidth), '#');
        std::fprintf(stderr, "\r%s [%s] %3.0f %%  %.0f s left \x1b[K%s", m_what.c_str(),
                     bar.c_str(), share * 100, left, last ? "\n" : "");
    } else {
        std::fprintf(stderr, "%s %3.0f %%  %.0f s left\n", m_what.c_str(), share * 100, left);
    }
    std::fflush(stderr);
}

}  // namespace terravox::exports
