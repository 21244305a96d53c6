#pragma once

#include <terravox/control.hpp>

#include <cstdint>
#include <mutex>

namespace terravox {

/// Counts the finished steps of a call, and reports them to Control::progress. Thread-safe.
class Steps {
public:
    Steps(const Control& control, std::uint64_t total) : m_control(control), m_total(total) {}

    void add_one() {
        const std::lock_guard lock(m_mutex);
        ++m_done;
        if (m_control.progress)
            m_control.progress(m_done, m_total);
    }

private:
    const Control& m_control;
    const std::uint64_t m_total;
    std::mutex m_mutex;
    std::uint64_t m_done = 0;
};

}  // namespace terravox
