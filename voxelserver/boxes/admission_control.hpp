#pragma once

#include <atomic>
#include <condition_variable>
#include <mutex>

#include "common/util/error.hpp"

namespace terravox::boxes {

/// More boxes are asked for than can be made soon: ask again later.
class OverloadedError : public util::Error {
public:
    using util::Error::Error;
};

/// Decides who makes boxes now. Thread-safe.
///
/// What somebody asked for goes first: a few at a time, a limited number in line, further ones
/// turned away at once. Work ahead of need begins only while nothing that was asked for runs or
/// waits, and never stands in its way: it has places of its own. One lock guards the counters and
/// is not held while work runs.
class AdmissionControl {
public:
    AdmissionControl(int inside, int waiting) : m_max_inside(inside), m_max_waiting(waiting) {}

    struct Counts {
        int running = 0, waiting = 0, ahead_running = 0;
    };
    [[nodiscard]] Counts counts() const;

    /// Work that somebody waits for.
    class Pass {
    public:
        explicit Pass(AdmissionControl& gate) : m_gate(gate) {
            m_gate.enter();
        }  ///< @throws OverloadedError when the line is full
        ~Pass() { m_gate.leave(); }
        Pass(const Pass&) = delete;
        Pass& operator=(const Pass&) = delete;

    private:
        AdmissionControl& m_gate;
    };

    /// Work ahead of need.
    class PrefetchPermit {
    public:
        explicit PrefetchPermit(AdmissionControl& gate)
            : m_gate(gate),
              m_inside(gate.enter_ahead()) {}  ///< waits until the machine is idle, or close()
        ~PrefetchPermit() {
            if (m_inside)
                m_gate.leave_ahead();
        }
        PrefetchPermit(const PrefetchPermit&) = delete;
        PrefetchPermit& operator=(const PrefetchPermit&) = delete;
        explicit operator bool() const noexcept {
            return m_inside;
        }  ///< false: closed, nothing is to be done

    private:
        AdmissionControl& m_gate;
        bool m_inside;
    };

    void close();   ///< no work ahead from now on
    void refuse();  ///< no work at all from now on: whoever waits, and whoever comes, gets
                    ///< OverloadedError
    [[nodiscard]] bool refusing() const;

private:
    void enter();
    void leave() noexcept;
    [[nodiscard]] bool enter_ahead();
    void leave_ahead() noexcept;
    const int m_max_inside, m_max_waiting;
    mutable std::mutex m_mutex;
    std::condition_variable m_left, m_idle;
    int m_inside = 0, m_waiting = 0, m_ahead = 0;
    bool m_closed = false, m_refused = false;
};

/// A limited number of places for callers who may have to wait for work, their own or that of
/// others. Thread-safe.
class Slots {
public:
    explicit Slots(int most) : m_max(most) {}

    class Place {
    public:
        explicit Place(Slots& places);  ///< @throws OverloadedError when all are taken
        ~Place() { --m_places.m_taken; }
        Place(const Place&) = delete;
        Place& operator=(const Place&) = delete;

    private:
        Slots& m_places;
    };

private:
    const int m_max;
    std::atomic<int> m_taken{0};
};

}  // namespace terravox::boxes
