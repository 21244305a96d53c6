#include "raytracer/apps/preview/frame_pacer.hpp"

#include <algorithm>

#include "raytracer/apps/preview/seconds.hpp"

namespace terravox::preview {
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
    return std::max(m_began + duration_of(kFrame_s - m_drawing_s), drawn + duration_of(kMinWork_s));
}

void FramePacer::end(Clock::time_point drawn, Clock::time_point traced,
                     Clock::time_point now) noexcept {
    const double drawing_s = seconds(drawn - m_began) + seconds(now - traced);
    m_drawing_s = 0.8 * m_drawing_s + 0.2 * std::min(drawing_s, kFrame_s);
}

}  // namespace terravox::preview
