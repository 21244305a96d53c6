#include "voxelserver/serve/boxes/admission_control.hpp"

#include <string>

namespace terravox::boxes {

AdmissionControl::Counts AdmissionControl::counts() const {
    const std::lock_guard lock(m_mutex);
    return {m_inside, m_waiting, m_ahead};
}

void AdmissionControl::enter() {
    std::unique_lock lock(m_mutex);
    const auto check = [&] {
        if (m_refused)
            throw OverloadedError("make a box: the server is shutting down");
    };
    check();
    if (m_inside >= m_max_inside) {
        if (m_waiting >= m_max_waiting)
            throw OverloadedError("make a box: " + std::to_string(m_inside) +
                                  " are being made and " + std::to_string(m_waiting) +
                                  " wait; retry later");
        ++m_waiting;
        m_left.wait(lock, [&] { return m_refused || m_inside < m_max_inside; });
        --m_waiting;
        check();
    }
    ++m_inside;
}

void AdmissionControl::leave() noexcept {
    {
        const std::lock_guard lock(m_mutex);
        --m_inside;
    }
    m_left.notify_one();
    m_idle.notify_all();
}

bool AdmissionControl::enter_ahead() {
    std::unique_lock lock(m_mutex);
    m_idle.wait(lock, [&] {
        return m_closed || (m_inside == 0 && m_waiting == 0 && m_ahead < m_max_inside);
    });
    if (m_closed)
        return false;
    ++m_ahead;
    return true;
}

void AdmissionControl::leave_ahead() noexcept {
    {
        const std::lock_guard lock(m_mutex);
        --m_ahead;
    }
    m_idle.notify_one();
}

void AdmissionControl::refuse() {
    {
        const std::lock_guard lock(m_mutex);
        m_refused = m_closed = true;
    }
    m_left.notify_all();
    m_idle.notify_all();
}

bool AdmissionControl::refusing() const {
    const std::lock_guard lock(m_mutex);
    return m_refused;
}

Slots::Permit::Permit(Slots& slots) : m_slots(slots) {
    if (++m_slots.m_taken <= m_slots.m_max)
        return;
    --m_slots.m_taken;
    throw OverloadedError("{}: {} {}; retry later", slots.m_attempt, slots.m_max, slots.m_state);
}

void AdmissionControl::close() {
    {
        const std::lock_guard lock(m_mutex);
        m_closed = true;
    }
    m_idle.notify_all();
}

}  // namespace terravox::boxes
