#include "raytracer/processors/absence_watchdog.hpp"

namespace terravox::processors {
namespace {

constexpr std::chrono::seconds kWarnAfter{1};
constexpr std::chrono::seconds kWarnEvery{10};

}  // namespace

void AbsenceWatchdog::set_absent(Time now) noexcept {
    m_absent = true;
    m_absent_since = now;
    m_warned.reset();
}

AbsenceWatchdog::Alarm AbsenceWatchdog::poll(Time now) noexcept {
    if (!m_absent)
        return Alarm::kNone;
    if (m_timeout && absent_for(now) > *m_timeout)
        return Alarm::kTimeout;
    if (absent_for(now) <= kWarnAfter || (m_warned && now - *m_warned <= kWarnEvery))
        return Alarm::kNone;
    m_warned = now;
    return Alarm::kWarn;
}

}  // namespace terravox::processors
