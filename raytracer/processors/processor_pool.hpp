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
#include "raytracer/processors/absence_watchdog.hpp"
#include "raytracer/processors/failure_log.hpp"
#include "raytracer/processors/lease_book.hpp"
#include "raytracer/processors/lease_planner.hpp"
#include "raytracer/processors/member_registry.hpp"
#include "raytracer/processors/pool_member.hpp"
#include "raytracer/processors/processor.hpp"
#include "raytracer/processors/result_queue.hpp"
#include "raytracer/processors/result_validator.hpp"

namespace terravox::processors {

/// take() of a member whose worker is gone: what it had goes to others.
class LostProcessor : public util::Error {
public:
    using util::Error::Error;
};
/// take() of a member that has sent what it should not: nothing of what it sent is kept.
class UntrustedProcessor : public util::Error {
public:
    using util::Error::Error;
};
/// take() of a member that cannot trace a band; others may.
class FailingProcessor : public util::Error {
public:
    FailingProcessor(const std::string& message, const tiles::RenderTile& at)
        : util::Error(message), band(at) {}
    tiles::RenderTile band;
};
/// No member for as long as was to be waited.
class NoProcessorsLeft : public util::Error {
public:
    using util::Error::Error;
};
/// A member was not to be trusted, and what it did cannot be taken out of the picture any more: it
/// must begin anew.
class PictureInvalidated : public util::Error {
public:
    using util::Error::Error;
};

struct PoolSettings {
    /// Of a lease; else three times what the member should take.
    std::chrono::milliseconds min_deadline{10'000};
    /// How long to wait without any member; none: for ever.
    std::optional<std::chrono::milliseconds> give_up;
    /// Of that many bands of a member that is not trusted, some rows of one are computed again, and
    /// some of its first.
    int check_every = 100;
    /// Of the choice of those; a member must not be able to predict it.
    std::uint64_t seed = 1;
    /// A processor to be trusted, for checks where no member is, and for all the work where every
    /// member has failed; made once, when it is first needed. None: nothing is checked then, and
    /// members that have all failed end the picture with an error.
    std::function<std::shared_ptr<TileProcessor>()> make_checker;
    /// A member is no more. Called without locks, on any thread. @param expelled it must not come
    /// back
    std::function<void(LeaseBook::Member, const std::string& why, bool expelled)> gone;
};

/// Several processors as one: any mix of green, threads and sockets, which come and go while it
/// runs. Every tile comes back once (again where it has to be mended: TileResult::again), with the
/// same pixels whoever made it.
///
/// Rows of tiles are leased to members in proportion to their measured speed, so that all end
/// together (LeasePlanner), with as much under way as hides a member's latency. A lost member's
/// leases go back at once, late ones after a deadline; when nothing else is left, idle members get
/// what others are at, and the first answer counts. Of members that are not trusted some bands are
/// made again by one that is (ResultValidator).
///
/// A member that cannot trace a band (FailingProcessor) is left out of the picture, and the band
/// goes to others. Three different members (Member::who) that fail at the same rows end the picture
/// with an error, unless this process traces, too; one that joins again and again counts once.
/// Where the last member that was there has failed, this process goes on by itself, with the
/// processor of make_checker, until the picture ends; whoever joins later takes part as well. So a
/// picture that can be made here is made, whoever fails and under however many names of one host;
/// and what nobody can trace ends with the error of this process.
///
/// The decisions are made by parts that have neither threads nor clocks; the pool connects them to
/// processors, threads and the time. One mutex guards all of them. Each member has a thread that
/// waits for its results. Tiles are handed to a processor, and callbacks made, without the lock.
class ProcessorPool final : public TileProcessor {
public:
    using MemberId = processors::MemberId;
    using Member = MemberSpec;
    using Status = MemberStatus;
    explicit ProcessorPool(PoolSettings settings);
    ~ProcessorPool() override;

    /// @throws Error when there is no thread for it: then it is no member
    MemberId add(Member member);
    /// What it has goes to others, and its processor is cancelled. Unknown ids are ignored.
    void remove(MemberId id, const std::string& why);
    /// It gets nothing more; what it has it may finish. @param given_back tiles of what it has that
    /// it will not begin
    void drain(MemberId id, const std::vector<tiles::RenderTile>& given_back);
    /// It gets nothing while this is so.
    void pause(MemberId id, bool on);

    [[nodiscard]] int capacity() const noexcept override;
    void submit(tiles::RenderTile tile) override;
    [[nodiscard]] bool wait(std::chrono::milliseconds most) override;
    /// @throws what a trusted member or make_checker threw; NoProcessorsLeft, PictureInvalidated;
    /// Error when three different members failed at the same rows
    std::optional<tiles::TileResult> take() override;
    [[nodiscard]] std::vector<std::uint32_t> take_invalidated() override;
    void close() noexcept override;
    void cancel() noexcept override;

    [[nodiscard]] std::vector<Status> status() const;
    struct Counts {
        std::uint64_t late = 0;        ///< answers to leases that somebody had answered before
        std::uint64_t unasked = 0;     ///< answers to no lease
        std::uint64_t checked = 0;     ///< answers to checks
        std::uint64_t expelled = 0;    ///< members
        std::uint64_t lost = 0;        ///< members that have left otherwise
        std::uint64_t given_back = 0;  ///< bands of members that left or were drained
        std::uint64_t second = 0;      ///< leases of bands that another member was computing
        std::uint64_t mended = 0;      ///< tiles that were taken again
    };
    [[nodiscard]] Counts counts() const;

private:
    using Clock = std::chrono::steady_clock;
    /// What waits for the results of a member. It lives until its thread has been joined.
    struct Pump {
        MemberSpec member;   ///< keeps what the member owns alive, if nothing else does
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
    [[nodiscard]] bool can_take() const noexcept;
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
    std::exception_ptr m_failure;      ///< ends the picture; the first one counts
    std::map<MemberId, Pump> m_pumps;  ///< also of members that have left, until they are joined
    Counts m_counts;
    bool m_closed = false, m_cancelled = false;
};

}  // namespace terravox::processors
