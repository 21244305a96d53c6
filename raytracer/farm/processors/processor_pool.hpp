#pragma once

#include <chrono>
#include <condition_variable>
#include <exception>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "common/util/error.hpp"
#include "raytracer/farm/processors/lease_book.hpp"
#include "raytracer/farm/processors/lease_planner.hpp"
#include "raytracer/farm/processors/pool_members.hpp"
#include "raytracer/farm/processors/pool_results.hpp"
#include "raytracer/farm/processors/processor.hpp"

namespace terravox::processors {

/// Thrown by take() of a member whose worker is lost: its leases are reassigned.
class LostProcessor : public util::Error {
public:
    using util::Error::Error;
};
/// Thrown by take() of a member that has sent something invalid: all its results are discarded.
class UntrustedProcessor : public util::Error {
public:
    using util::Error::Error;
};
/// Thrown by take() of a member that cannot trace a band; others may.
class FailingProcessor : public util::Error {
public:
    FailingProcessor(const std::string& message, const tiles::RenderTile& at)
        : util::Error(message), band(at) {}
    tiles::RenderTile band;
};
/// There was no member for longer than PoolSettings::give_up (AbsenceWatchdog).
class NoProcessorsLeft : public util::Error {
public:
    using util::Error::Error;
};
/// A member turned out to be untrustworthy, and its results cannot be removed from the picture any
/// more: the picture must start again.
class PictureInvalidated : public util::Error {
public:
    using util::Error::Error;
};

struct PoolSettings {
    /// Minimum deadline of a lease; else it is three times the expected duration.
    std::chrono::milliseconds min_deadline{10'000};
    /// How long to wait without any member, since the last result; nullopt: forever.
    std::optional<std::chrono::milliseconds> give_up;
    /// Some rows of one of this many bands of an untrusted member are recomputed, and some rows of
    /// its first band.
    int check_every = 100;
    /// Seed of that choice; a member must not be able to predict it.
    std::uint64_t seed = 1;
    /// Makes a trusted processor, for checks if no member is trusted, and for all work if every
    /// member has failed. Called once, when it is first needed. Empty: nothing is checked then, and
    /// the picture ends with an error when all members have failed.
    std::function<std::shared_ptr<TileProcessor>()> make_checker;
    /// Called when a member has left, without locks, on any thread.
    /// @param expelled the member must not be admitted again
    std::function<void(LeaseBook::Member, const std::string& why, bool expelled)> gone;
};

/// Several processors as one: any mix of green, threads and sockets, which join and leave while it
/// runs. Every tile is returned once (twice if it must be mended: TileResult::again), with the same
/// pixels whichever member computed it.
///
/// Rows of tiles are leased to members in proportion to their measured speed, so that all end
/// together (LeasePlanner), with as much under way as hides a member's latency. A lost member's
/// leases are reassigned at once, late ones after a deadline; when nothing else is left, idle
/// members repeat what others are computing, and the first answer counts. Some bands of untrusted
/// members are recomputed by a trusted one (ResultValidator).
///
/// A member that cannot trace a band (FailingProcessor) is left out of the picture, and the band is
/// reassigned. Three different members (Member::identity) that fail at the same rows end the
/// picture with an error, unless this process traces, too; one that joins repeatedly counts once.
/// When the last member has failed, this process continues alone, with the processor of
/// make_checker, until the picture ends; members that join later take part as well. So a picture
/// that can be made here is made, whichever members fail and under however many names of one host;
/// and a band that no member can trace ends the picture with the error of this process.
///
/// The decisions are made by parts that have neither threads nor clocks; the pool connects them to
/// processors, threads and the time. One mutex guards all of them. Each member has a thread that
/// waits for its results. Tiles are submitted to processors, and callbacks called, without the
/// lock.
class ProcessorPool final : public TileProcessor {
public:
    using MemberId = processors::MemberId;
    using Member = MemberSpec;
    using Status = MemberStatus;
    explicit ProcessorPool(PoolSettings settings);
    ~ProcessorPool() override;

    /// Adds a member.
    /// @throws Error when no thread can be started for it; it is not a member then
    MemberId add(Member member);
    /// Removes a member: its leases are reassigned, and its processor is cancelled. Unknown ids are
    /// ignored.
    void remove(MemberId id, const std::string& why) { on_member_lost(id, why, false); }
    /// Leases nothing more to the member; it may finish its leases.
    /// @param given_back tiles of its leases that it will not begin
    void drain(MemberId id, const std::vector<tiles::RenderTile>& given_back);
    /// Leases nothing to the member while it is paused.
    void pause(MemberId id, bool on);

    [[nodiscard]] int capacity() const noexcept override;
    void submit(tiles::RenderTile tile) override;
    [[nodiscard]] bool wait(std::chrono::milliseconds timeout) override;
    /// @throws what a trusted member or make_checker threw; NoProcessorsLeft, PictureInvalidated;
    /// Error when three different members failed at the same rows
    std::optional<tiles::TileResult> take() override;
    [[nodiscard]] std::vector<std::uint32_t> take_invalidated() override;
    void close() noexcept override;
    void cancel() noexcept override;

    [[nodiscard]] std::vector<Status> status() const;
    struct Counts {
        std::uint64_t late = 0;  ///< answers to leases that another member had answered before
        std::uint64_t unrequested = 0;  ///< answers without a lease
        std::uint64_t checked = 0;      ///< answers to checks
        std::uint64_t expelled = 0;     ///< members
        std::uint64_t lost = 0;         ///< members that have left for other reasons
        std::uint64_t given_back = 0;   ///< bands of members that left or were drained
        std::uint64_t second = 0;       ///< leases of bands that another member was computing
        std::uint64_t mended = 0;       ///< tiles that were returned again
    };
    [[nodiscard]] Counts counts() const;

private:
    using Clock = std::chrono::steady_clock;
    /// Waits for the results of a member. It lives until its thread has been joined.
    struct Pump {
        MemberSpec member;   ///< keeps the member's processor alive, if nothing else does
        std::thread thread;  ///< none for a member that works on the caller's thread
    };
    MemberId begin_member(Member member, bool checks_only);
    void pump(MemberId id, std::shared_ptr<TileProcessor> processor);
    void run_green(Clock::time_point until);
    [[nodiscard]] bool accept(MemberId id, tiles::TileResult&& result);
    void count(LeaseBook::Answer answer) noexcept;
    void on_member_lost(MemberId id, const std::string& why, bool expelled,
                        const tiles::RenderTile* failed = nullptr);
    void return_leases(MemberId id);
    void revoke_results(MemberId id, const std::string& why);
    void note_failure(MemberId id, const Member& member, const tiles::RenderTile& band,
                      const std::string& why);
    void need_checker(std::unique_lock<std::mutex>& lock);
    void stand_in(std::unique_lock<std::mutex>& lock, const std::string& why);
    void feed();
    void tick(std::unique_lock<std::mutex>& lock);
    [[nodiscard]] bool expire_leases(Clock::time_point now);
    void watch_for_members(Clock::time_point now);
    void join_ended_pumps();
    void fail(std::exception_ptr failure) noexcept;
    [[nodiscard]] bool can_take() const noexcept {
        return m_results.can_take(m_book.open_checks() > 0);
    }
    [[nodiscard]] bool has_answer() const noexcept;

    const PoolSettings m_settings;
    mutable std::mutex m_mutex;
    std::condition_variable m_done;
    LeaseBook m_book;
    MemberRegistry m_members;
    LeasePlanner m_planner;
    ResultValidator m_validator;
    ResultQueue m_results;
    FailureLog m_failures;
    AbsenceWatchdog m_watchdog;
    std::exception_ptr m_failure;      ///< ends the picture; the first failure counts
    std::map<MemberId, Pump> m_pumps;  ///< also of members that have left, until they are joined
    Counts m_counts;
    bool m_closed = false;
    bool m_cancelled = false;
};

}  // namespace terravox::processors
