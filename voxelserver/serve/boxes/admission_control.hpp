#pragma once

#include <atomic>
#include <condition_variable>
#include <mutex>

#include "common/util/error.hpp"

namespace terravox::boxes {

/// More boxes are requested than can be made soon: the client should retry later.
class OverloadedError : public util::Error {
public:
    using util::Error::Error;
};

/// Schedules the making of boxes. Thread-safe.
///
/// Requested work has priority: a few boxes at a time, a limited number in the queue; further
/// requests are rejected at once. Prefetching starts only while no requested work is running or
/// waiting, and never delays it: it has slots of its own. One lock guards the counters and is not
/// held while work runs.
class AdmissionControl {
public:
    AdmissionControl(int inside, int waiting) : m_max_inside(inside), m_max_waiting(waiting) {}

    struct Counts {
        int running = 0;
        int waiting = 0;
        int ahead_running = 0;
    };
    [[nodiscard]] Counts counts() const;

    /// RAII permit for requested work, for which a caller waits.
    class Permit {
    public:
        /// Waits in the queue for its turn.
        /// @throws OverloadedError when the queue is full
        explicit Permit(AdmissionControl& control) : m_control(control) { m_control.enter(); }
        ~Permit() { m_control.leave(); }
        Permit(const Permit&) = delete;
        Permit& operator=(const Permit&) = delete;

    private:
        AdmissionControl& m_control;
    };

    /// RAII permit for prefetching.
    class PrefetchPermit {
    public:
        /// Waits until the machine is idle, or close().
        explicit PrefetchPermit(AdmissionControl& control)
            : m_control(control), m_inside(control.enter_ahead()) {}
        ~PrefetchPermit() {
            if (m_inside)
                m_control.leave_ahead();
        }
        PrefetchPermit(const PrefetchPermit&) = delete;
        PrefetchPermit& operator=(const PrefetchPermit&) = delete;
        /// False when the control was closed: no work must be done.
        explicit operator bool() const noexcept { return m_inside; }

    private:
        AdmissionControl& m_control;
        bool m_inside;
    };

    void close();  ///< stops prefetching from now on
    /// Stops all work from now on: waiting and new requests fail with OverloadedError.
    void refuse();
    [[nodiscard]] bool refusing() const;

private:
    void enter();
    void leave() noexcept;
    [[nodiscard]] bool enter_ahead();
    void leave_ahead() noexcept;
    const int m_max_inside;
    const int m_max_waiting;
    mutable std::mutex m_mutex;
    std::condition_variable m_left;
    std::condition_variable m_idle;
    int m_inside = 0;
    int m_waiting = 0;
    int m_ahead = 0;
    bool m_closed = false;
    bool m_refused = false;
};

/// A limited number of slots for callers that may have to wait for work, their own or that of other
/// threads. Thread-safe.
class Slots {
public:
    /// @param attempt, state  words of the refusal: "wait for a box", "requests wait already"
    Slots(int max, const char* attempt, const char* state)
        : m_max(max), m_attempt(attempt), m_state(state) {}

    class Permit {
    public:
        explicit Permit(Slots& slots);  ///< @throws OverloadedError when all are taken
        ~Permit() { --m_slots.m_taken; }
        Permit(const Permit&) = delete;
        Permit& operator=(const Permit&) = delete;

    private:
        Slots& m_slots;
    };

private:
    const int m_max;
    const char* const m_attempt;
    const char* const m_state;
    std::atomic<int> m_taken{0};
};

}  // namespace terravox::boxes
