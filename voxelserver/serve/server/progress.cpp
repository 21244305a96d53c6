#include "voxelserver/serve/server/progress.hpp"
#include "common/util/log.hpp"

#include <algorithm>
#include <cstdio>
#include <string>

namespace terravox::serve {
namespace {

constexpr std::uint64_t kReportEach_percent = 10;
constexpr int kBarWidth = 30;

std::string duration_text(double seconds) {
    char out[32];
    const auto whole = static_cast<long>(seconds + 0.5);
    if (whole >= 3600)
        std::snprintf(out, sizeof out, "%ld h %02ld min", whole / 3600, whole / 60 % 60);
    else if (whole >= 60)
        std::snprintf(out, sizeof out, "%ld min %02ld s", whole / 60, whole % 60);
    else
        std::snprintf(out, sizeof out, "%ld s", whole);
    return out;
}

}  // namespace

void PrepareProgress::show(const boxes::Preparer::Progress& now) {
    const double seconds = std::chrono::duration<double>(Clock::now() - m_start).count();
    const double share =
        now.total > 0 ? static_cast<double>(now.done) / static_cast<double>(now.total) : 1;
    if (m_bar) {
        const int full = static_cast<int>(share * kBarWidth);
        const std::string bar = std::string(static_cast<std::size_t>(full), '#') +
                                std::string(static_cast<std::size_t>(kBarWidth - full), '.');
        const std::string left =
            share > 0.01 ? ", " + duration_text(seconds / share - seconds) + " left" : "";
        std::fprintf(stderr, "\rpreparing [%s] %3.0f %%, %llu of %llu boxes%s\033[K", bar.c_str(),
                     share * 100, static_cast<unsigned long long>(now.done),
                     static_cast<unsigned long long>(now.total), left.c_str());
        return;
    }
    const auto percent = static_cast<std::uint64_t>(share * 100);
    if (percent < m_reported_percent + kReportEach_percent)
        return;
    m_reported_percent = percent - percent % kReportEach_percent;
    util::log_info("preparing: {} % of {} boxes", m_reported_percent, now.total);
}

void PrepareProgress::end(const boxes::Preparer::Progress& now) {
    if (m_bar)
        std::fprintf(stderr, "\r\033[K");
    const double seconds = std::chrono::duration<double>(Clock::now() - m_start).count();
    if (now.failed == 0 && now.done >= now.total)
        util::log_info("prepared: {} boxes in {}", now.done, duration_text(seconds));
    else
        util::log_warn("prepared: {} of {} boxes in {}; {} cannot be made", now.done - now.failed,
                       now.total, duration_text(seconds), now.failed);
}

}  // namespace terravox::serve
