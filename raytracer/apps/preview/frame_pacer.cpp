#include "raytracer/apps/preview/frame_pacer.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace terravox::preview {
namespace {

constexpr std::size_t kMax =
    1'000'000;  // hours of frames; what comes later is like what came before

nlohmann::json quantiles(std::vector<float> values) {
    if (values.empty())
        return {{"count", 0}};
    std::sort(values.begin(), values.end());
    const auto at = [&](double share) {
        return static_cast<double>(
            values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))]);
    };
    return {{"count", values.size()},
            {"median_s", at(0.5)},
            {"p95_s", at(0.95)},
            {"p99_s", at(0.99)},
            {"most_s", at(1)}};
}

}  // namespace

void FrameTimes::note(std::vector<float>& to, double seconds) {
    if (&to == &m_frames)
        m_recent_s = m_recent_s == 0 ? seconds : 0.9 * m_recent_s + 0.1 * seconds;
    if (to.size() < kMax)
        to.push_back(static_cast<float>(seconds));
}

nlohmann::json FrameTimes::report() const {
    return {{"frames", quantiles(m_frames)},
            {"first_pictures", quantiles(m_firsts)},
            {"stops", quantiles(m_stops)}};
}

namespace {

constexpr double kFrame_s = 1.0 / 60;
// Minimum tracing time of each frame, however long drawing takes: else a picture might never be
// finished.
constexpr double kMinWork_s = 0.004;
constexpr double kIdle_s = 0.25;      // between two frames without input
constexpr int kSettlingFrames = 3;    // after input
constexpr double kWaitedFully = 0.9;  // a shorter share of the wait was ended by an event

}  // namespace

double FramePacer::wait_s(Activity activity) noexcept {
    switch (activity) {
        case Activity::kComputing: return 0;
        case Activity::kAnimated: return kFrame_s;
        case Activity::kIdle: break;
    }
    return kIdle_s;
}

double FramePacer::begin(Clock::time_point waiting_since, double wait_s, bool had_input,
                         Clock::time_point now) noexcept {
    const bool woken = had_input || seconds(now - waiting_since) < wait_s * kWaitedFully;
    m_settling = woken ? kSettlingFrames : std::max(m_settling - 1, 0);
    const double since_last_s = seconds(now - m_began);
    m_began = now;
    return since_last_s;
}

FramePacer::Clock::time_point FramePacer::work_until(Clock::time_point drawn) const noexcept {
    return std::max(m_began + to_duration(kFrame_s - m_drawing_s), drawn + to_duration(kMinWork_s));
}

void FramePacer::end(Clock::time_point drawn, Clock::time_point traced,
                     Clock::time_point now) noexcept {
    const double drawing_s = seconds(drawn - m_began) + seconds(now - traced);
    m_drawing_s = 0.8 * m_drawing_s + 0.2 * std::min(drawing_s, kFrame_s);
}

}  // namespace terravox::preview
