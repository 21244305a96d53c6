#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "raytracer/farm/processors/lease_book.hpp"
#include "raytracer/farm/processors/processor.hpp"
#include "raytracer/farm/processors/speed_meter.hpp"

namespace terravox::processors {

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
    [[nodiscard]] std::size_t threads() const noexcept;
    /// @return number of leases that its processor can use at once, at least 1
    [[nodiscard]] std::size_t max_leases() const noexcept;
    [[nodiscard]] double latency_s() const;
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
    [[nodiscard]] bool take_check_request() noexcept;

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

}  // namespace terravox::processors
