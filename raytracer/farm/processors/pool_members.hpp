#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "raytracer/farm/processors/lease_book.hpp"
#include "raytracer/farm/processors/processor.hpp"

namespace terravox::processors {

/// Measures how many pixels a second a member computes while it has work. Recent seconds count more
/// than earlier ones, so that the estimate adapts to a machine that gets other load. It reads
/// no clock. Not thread-safe.
class SpeedMeter {
public:
    using Time = std::chrono::steady_clock::time_point;

    /// @param has_warm_up  whether the time before the first answer is ignored, as a worker
    /// prepares the picture then
    explicit SpeedMeter(bool has_warm_up) noexcept : m_is_warming_up(has_warm_up) {}

    /// The member has work from now on; nothing changes if it had some already.
    void start(Time now) noexcept;
    /// Counts the time since start() or the last call, if the member has work.
    void advance(Time now) noexcept;
    /// The member has no work any more.
    void stop(Time now) noexcept;
    /// Counts an answer with this many pixels; advance() must have been called before.
    void add_answer(std::size_t pixels) noexcept;

    /// @return 0 while the speed is unknown
    [[nodiscard]] double pixels_per_s() const noexcept {
        return m_recent_s > 0 ? m_recent_pixels / m_recent_s : 0;
    }
    [[nodiscard]] bool is_busy() const noexcept { return m_is_busy; }
    /// @return all the time with work, in seconds
    [[nodiscard]] double busy_s(Time now) const noexcept;

private:
    bool m_is_warming_up;
    bool m_is_busy = false;
    Time m_counted_until;  ///< end of the time with work that is counted
    double m_recent_pixels = 0;
    double m_recent_s = 0;
    double m_busy_s = 0;
};

using MemberId = LeaseBook::Member;

/// A processor that joins a pool.
struct MemberSpec {
    std::string name;       ///< for display
    const char* kind = "";  ///< green, threads, socket
    int threads = 1;
    bool trusted = false;    ///< it is of this process
    bool on_caller = false;  ///< it works on the thread that calls wait() and take(): green
    std::shared_ptr<TileProcessor> processor;
    std::function<double()> latency_s;  ///< round-trip time; empty: 0
    bool paused = false;
    /// The identity by which failures are counted, of which a machine cannot have many: the name in
    /// its certificate or its host. Empty: the member differs from all others.
    std::string identity = {};
};

/// The state of a member for display.
struct MemberStatus {
    MemberId id = 0;
    std::string name;
    const char* kind = "";
    const char* state = "";  ///< working, waiting, paused, draining, late
    int threads = 1;
    std::uint64_t bands = 0;
    std::uint64_t pixels = 0;
    double pixels_per_s = 0;
    double latency_s = 0;
    double busy_share = 0;
    std::size_t leases = 0;
};

/// The record of one member of a pool: whether it may be given work, how fast it is, and what it
/// has done. It has no thread and reads no clock. Not thread-safe.
class PoolMember {
public:
    using Time = LeaseBook::Time;

    /// @param checks_only it only checks the bands of others
    PoolMember(MemberSpec spec, bool checks_only, Time now);

    [[nodiscard]] const MemberSpec& spec() const noexcept { return m_spec; }
    [[nodiscard]] bool checks_only() const noexcept { return m_checks_only; }
    /// @return at least 1
    [[nodiscard]] std::size_t threads() const noexcept {
        return static_cast<std::size_t>(std::max(m_spec.threads, 1));
    }
    /// @return number of leases that its processor can use at once, at least 1
    [[nodiscard]] std::size_t max_leases() const noexcept {
        return static_cast<std::size_t>(std::max(m_spec.processor->capacity(), 1));
    }
    [[nodiscard]] double latency_s() const { return m_spec.latency_s ? m_spec.latency_s() : 0; }
    [[nodiscard]] double pixels_per_s() const noexcept { return m_speed.pixels_per_s(); }
    [[nodiscard]] std::uint64_t bands() const noexcept { return m_bands; }

    void drain() noexcept { m_draining = true; }
    void pause(bool on) noexcept { m_paused = on; }
    /// To be called when it has missed a deadline.
    /// @return whether it was not late before
    [[nodiscard]] bool set_late() noexcept;
    /// @return whether it may be given bands
    [[nodiscard]] bool is_available() const noexcept { return !m_draining && !m_paused && !m_late; }
    /// @return whether it was late, and has not answered since: it gets one band at a time
    [[nodiscard]] bool is_on_probation() const noexcept { return m_on_probation; }

    void on_lease(Time now) noexcept { m_speed.start(now); }
    /// To be called when it has no lease. Others have computed the bands that it was late with, so
    /// it may try again.
    void on_idle(Time now) noexcept;
    /// Counts the time up to an answer, before the answer is validated.
    void count_time(Time now) noexcept { m_speed.advance(now); }
    /// To be called for each answer to a lease, valid or not.
    void on_answer(std::size_t pixels) noexcept;
    /// Counts a valid band.
    void add_band(std::size_t pixels) noexcept;

    /// Requests a check of its next band, too, because the last check was inconclusive.
    void request_check() noexcept { m_check_requested = true; }
    /// @return whether request_check() has been called since the last call
    [[nodiscard]] bool take_check_request() noexcept {
        return std::exchange(m_check_requested, false);
    }

    [[nodiscard]] MemberStatus status(MemberId id, std::size_t leases, Time now) const;

private:
    [[nodiscard]] const char* state() const noexcept;

    MemberSpec m_spec;
    bool m_checks_only;
    SpeedMeter m_speed;
    Time m_joined;
    bool m_draining = false;
    bool m_paused;
    bool m_late = false;
    bool m_on_probation = false;
    bool m_check_requested = false;
    std::uint64_t m_bands = 0;
    std::uint64_t m_pixels = 0;
};

/// The members of a pool, and which kind of work each of them takes. It has no thread and reads no
/// clock. Not thread-safe.
///
/// The *checker* is a member that the pool makes itself if no other one is trusted: it checks the
/// bands of others. When it stands in for members that have failed, it traces as well.
class MemberRegistry {
public:
    using Time = LeaseBook::Time;

    /// @param checks_only whether it is the checker
    MemberId add(MemberSpec spec, bool checks_only, Time now);
    /// @return the member that was removed; nullopt for an unknown id
    std::optional<PoolMember> remove(MemberId id);
    /// @return nullptr for an unknown id
    [[nodiscard]] PoolMember* find(MemberId id) noexcept;
    [[nodiscard]] const PoolMember* find(MemberId id) const noexcept;
    /// All members, in the order in which they joined.
    [[nodiscard]] std::map<MemberId, PoolMember>& all() noexcept { return m_members; }
    [[nodiscard]] const std::map<MemberId, PoolMember>& all() const noexcept { return m_members; }

    /// @return whether there is any member apart from the checker
    [[nodiscard]] bool has_workers() const noexcept;
    /// @return whether the member takes bands, apart from checks
    [[nodiscard]] bool takes_work(const PoolMember& member) const noexcept {
        return (!member.checks_only() || m_stands_in) && member.is_available();
    }
    /// @return whether a member of this process traces bands that others cannot
    [[nodiscard]] bool traces_here() const noexcept;
    /// @return the total speed of the members that take work
    [[nodiscard]] double pixels_per_s() const noexcept;

    /// @return true, once, if no member is trusted: the caller must then make the checker
    [[nodiscard]] bool claim_checker() noexcept;
    /// From now on the checker traces bands, too.
    void stand_in() noexcept { m_stands_in = true; }
    [[nodiscard]] bool stands_in() const noexcept { return m_stands_in; }

private:
    std::map<MemberId, PoolMember> m_members;
    MemberId m_next_id = 1;
    bool m_checker_claimed = false;
    bool m_stands_in = false;
};

/// Watches how long a pool has been without members: when to warn, and when to give up. The time
/// adds up until a member answers: members that come and go again without a result do not prolong
/// the wait. It reads no clock. Not thread-safe.
class AbsenceWatchdog {
public:
    using Time = std::chrono::steady_clock::time_point;
    using Duration = std::chrono::steady_clock::duration;
    enum class Alarm : std::uint8_t {
        kNone,
        kWarn,
        kTimeout,
    };

    /// A pool begins without members.
    /// @param timeout  how long to wait without members; nullopt: forever
    AbsenceWatchdog(std::optional<Duration> timeout, Time now) noexcept
        : m_timeout(timeout), m_absent_since(now), m_warned(now) {}

    /// There is at least one member. Idempotent.
    void set_present(Time now) noexcept;
    /// The last member has left. Idempotent.
    void set_absent(Time now) noexcept;
    /// A member has sent a result, so the next wait begins anew.
    void set_answered() noexcept;

    /// To be called regularly while there is work.
    /// @return kWarn at most every ten seconds; kTimeout always once the timeout has passed, while
    /// there is no member
    [[nodiscard]] Alarm poll(Time now) noexcept;
    /// @return the time without members since the last result, or since the beginning
    [[nodiscard]] Duration absent_for(Time now) const noexcept {
        return m_absent_since ? m_absent_before + (now - *m_absent_since) : m_absent_before;
    }

private:
    std::optional<Duration> m_timeout;
    Duration m_absent_before{};  ///< in earlier stretches since the last result
    std::optional<Time> m_absent_since;
    std::optional<Time> m_warned;
};

}  // namespace terravox::processors
