#pragma once

#include <atomic>
#include <condition_variable>
#include <mutex>

#include "common/util/error.hpp"

namespace terravox::boxes {

/// More boxes are asked for than can be made soon: ask again later.
class Busy : public Error {
public:
    using Error::Error;
};

/// Decides who makes boxes now. Thread-safe.
///
/// What somebody asked for goes first: a few at a time, a limited number in line, further ones
/// turned away at once. Work ahead of need begins only while nothing that was asked for runs or
/// waits, and never stands in its way: it has places of its own. One lock guards the counters and
/// is not held while work runs.
class Gate {
public:
    Gate(int inside, int waiting) : m_most_inside(inside), m_most_waiting(waiting) {}

    struct Counts {
        int running = 0, waiting = 0, ahead_running = 0;
    };
    [[nodiscard]] Counts counts() const;

    /// Work that somebody waits for.
    class Pass {
    public:
        explicit Pass(Gate& gate) : m_gate(gate) {
            m_gate.enter();
        }  ///< @throws Busy when the line is full
        ~Pass() { m_gate.leave(); }
        Pass(const Pass&) = delete;
        Pass& operator=(const Pass&) = delete;

    private:
        Gate& m_gate;
    };

    /// Work ahead of need.
    class AheadPass {
    public:
        explicit AheadPass(Gate& gate)
            : m_gate(gate),
              m_inside(gate.enter_ahead()) {}  ///< waits until the machine is idle, or close()
        ~AheadPass() {
            if (m_inside)
                m_gate.leave_ahead();
        }
        AheadPass(const AheadPass&) = delete;
        AheadPass& operator=(const AheadPass&) = delete;
        explicit operator bool() const noexcept {
            return m_inside;
        }  ///< false: closed, nothing is to be done

    private:
        Gate& m_gate;
        bool m_inside;
    };

    void close();   ///< no work ahead from now on
    void refuse();  ///< no work at all from now on: whoever waits, and whoever comes, gets Busy
    [[nodiscard]] bool refusing() const;

private:
    void enter();
    void leave() noexcept;
    [[nodiscard]] bool enter_ahead();
    void leave_ahead() noexcept;
    const int m_most_inside, m_most_waiting;
    mutable std::mutex m_mutex;
    std::condition_variable m_left, m_idle;
    int m_inside = 0, m_waiting = 0, m_ahead = 0;
    bool m_closed = false, m_refused = false;
};

/// A limited number of places for callers who may have to wait for work, their own or that of
/// others. Thread-safe.
class Places {
public:
    explicit Places(int most) : m_most(most) {}

    class Place {
    public:
        explicit Place(Places& places);  ///< @throws Busy when all are taken
        ~Place() { --m_places.m_taken; }
        Place(const Place&) = delete;
        Place& operator=(const Place&) = delete;

    private:
        Places& m_places;
    };

private:
    const int m_most;
    std::atomic<int> m_taken{0};
};

}  // namespace terravox::boxes
