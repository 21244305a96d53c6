#include "raytracer/farm/processors/absence_watchdog.hpp"

namespace terravox::processors {
namespace {

constexpr std::chrono::seconds kWarnAfter{1};
constexpr std::chrono::seconds kWarnEvery{10};

}  // namespace

void AbsenceWatchdog::set_present(Time now) noexcept {
    m_absent_before = absent_for(now);
    m_absent_since.reset();
}

void AbsenceWatchdog::set_absent(Time now) noexcept {
    if (!m_absent_since)
        m_absent_since = now;
}

void AbsenceWatchdog::set_answered() noexcept {
    m_absent_before = {};
    m_warned.reset();
}

AbsenceWatchdog::Alarm AbsenceWatchdog::poll(Time now) noexcept {
    if (!m_absent_since)
        return Alarm::kNone;
    if (m_timeout && absent_for(now) > *m_timeout)
        return Alarm::kTimeout;
    if (absent_for(now) <= kWarnAfter || (m_warned && now - *m_warned <= kWarnEvery))
        return Alarm::kNone;
    m_warned = now;
    return Alarm::kWarn;
}

AbsenceWatchdog::Duration AbsenceWatchdog::absent_for(Time now) const noexcept {
    return m_absent_since ? m_absent_before + (now - *m_absent_since) : m_absent_before;
}

}  // namespace terravox::processors
