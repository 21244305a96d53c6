#pragma once

#include <chrono>
#include <condition_variable>
#include <deque>
#include <exception>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <unordered_set>
#include <vector>

#include "common/util/error.hpp"
#include "raytracer/processors/lease_book.hpp"
#include "raytracer/processors/processor.hpp"

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
    std::chrono::milliseconds min_deadline{
        10'000};  ///< of a lease; else three times what the member should take
    std::optional<std::chrono::milliseconds>
        give_up;             ///< how long to wait without any member; none: for ever
    int check_every = 100;   ///< of that many bands of a member that is not to be trusted some rows
                             ///< of one are made again, and some of its first
    std::uint64_t seed = 1;  ///< of the choice of those; not to be foreseen by a member
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
/// together (weighted factoring: Hummel, Schmidt, Uma, Wein, "Load-sharing in heterogeneous systems
/// via weighted factoring", SPAA 1996), with as much under way as hides a member's latency. A lost
/// member's leases go back at once, late ones after a deadline; when nothing else is left, idle
/// members get what others are at, and the first answer counts. Of members that are not trusted
/// some bands are made again by one that is.
///
/// A member that cannot trace a band (FailingProcessor) is left out of the picture, and the band
/// goes to others. Three different members (Member::who) that fail at the same rows end the picture
/// with an error, unless this process traces, too; one that joins again and again counts once.
/// Where the last member that was there has failed, this process goes on by itself, with the
/// processor of make_checker, until the picture ends; whoever joins later takes part as well. So a
/// picture that can be made here is made, whoever fails and under however many names of one host;
/// and what nobody can trace ends with the error of this process.
///
/// One mutex guards the book and the members. Each member has a thread that waits for its results.
/// Tiles are handed to a processor, and callbacks made, without the lock.
class ProcessorPool final : public TileProcessor {
public:
    using MemberId = LeaseBook::Member;
    struct Member {
        std::string name;       ///< for people
        const char* kind = "";  ///< green, threads, socket
        int threads = 1;
        bool trusted = false;    ///< of this process
        bool on_caller = false;  ///< it works on the thread that calls wait() and take(): green
        std::shared_ptr<TileProcessor> processor;
        std::function<double()> latency_s;  ///< there and back; none: 0
        bool paused = false;
        /// Who it is when failures are counted: what it cannot have many of, as the name in its
        /// certificate or its host. Empty: none of the others.
        std::string who = {};
    };
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

    struct Status {
        MemberId id = 0;
        std::string name;
        const char* kind = "";
        const char* state = "";  ///< working, waiting, paused, draining, late
        int threads = 1;
        std::uint64_t bands = 0, pixels = 0;
        double pixels_per_s = 0, latency_s = 0, busy_share = 0;
        std::size_t leases = 0;
    };
    [[nodiscard]] std::vector<Status> status() const;
    struct Counts {
        std::uint64_t late = 0, unasked = 0, checked = 0, expelled = 0, lost = 0, given_back = 0,
                      second = 0, mended = 0;
    };
    [[nodiscard]] Counts counts() const;

private:
    using Clock = std::chrono::steady_clock;
    struct State {
        Member is;
        std::thread pump;
        bool draining = false, paused = false, late = false, gone = false;
        bool checks_only =
            false;  ///< the processor of make_checker; where it stands in, it takes other work, too
        bool check_next = false;  ///< its next band: the last check of one decided nothing
        bool doubtful = false;    ///< it was late, and has not answered since: one band at a time
        std::uint64_t bands = 0, pixels = 0, answers = 0;
        double recent_pixels = 0, recent_s = 0, busy_s = 0;
        Clock::time_point since,
            mark;  ///< when it came; since when it has been busy, as far as counted
        bool busy = false, started = false;  ///< started: it has answered
        [[nodiscard]] double speed() const noexcept {
            return recent_s > 0 ? recent_pixels / recent_s : 0;
        }
    };
    /// Rows that a member could not trace.
    struct Failure {
        tiles::RenderTile band;
        std::string who;
    };
    /// A band on its way to a processor.
    struct Dispatch {
        std::shared_ptr<TileProcessor> to;
        tiles::RenderTile band;
    };
    struct Withdrawal {
        std::shared_ptr<TileProcessor> from;
        tiles::RenderTile band;
    };
    MemberId begin_member(std::unique_ptr<State> state);
    void pump(MemberId id, std::shared_ptr<TileProcessor> processor);
    void run_green(Clock::time_point until);
    [[nodiscard]] bool accept(MemberId id, tiles::TileResult&& result);
    void left(MemberId id, const std::string& why, bool expelled,
              const tiles::RenderTile* failed = nullptr);
    void feed();
    void plan_member(MemberId id, State& member, Clock::time_point now, std::vector<Dispatch>& out);
    [[nodiscard]] std::size_t wanted_pixels(const State& member) const;
    bool give_again(MemberId id, State& member, Clock::time_point now, std::vector<Dispatch>& out);
    void lease_to(MemberId id, State& member, const tiles::RenderTile& band, Clock::time_point now,
                  std::vector<Dispatch>& out);
    void reassign(std::size_t bands, Clock::time_point now, std::vector<Dispatch>& out);
    void count_time(State& member, Clock::time_point now);
    void tick(std::unique_lock<std::mutex>& lock);
    void need_checker(std::unique_lock<std::mutex>& lock);
    void note_failure(MemberId id, const State& member, const tiles::RenderTile& band,
                      const std::string& why);
    void stand_in(std::unique_lock<std::mutex>& lock, const std::string& why);
    [[nodiscard]] bool takes_work(const State& member) const noexcept;
    [[nodiscard]] bool traces_here() const noexcept;
    [[nodiscard]] bool can_hand_out() const noexcept;
    [[nodiscard]] bool has_answer() const noexcept;
    [[nodiscard]] double all_speeds() const noexcept;
    [[nodiscard]] bool to_check(State& member);
    [[nodiscard]] tiles::RenderTile rows_to_check(tiles::RenderTile band);
    [[nodiscard]] std::uint64_t next_random() noexcept;

    const PoolSettings m_settings;
    mutable std::mutex m_mutex;
    std::condition_variable m_done;
    LeaseBook m_book;
    std::map<MemberId, std::unique_ptr<State>> m_members;
    std::vector<std::unique_ptr<State>> m_leaving;  ///< whose threads are to be joined
    std::deque<tiles::TileResult> m_ready;
    std::vector<std::uint32_t> m_doubted;
    std::unordered_set<std::uint32_t> m_handed;  ///< tiles of this pass that have been handed out
    std::uint64_t m_pass_key = 0;
    std::size_t m_first_left = 0,
                m_again_left = 0;  ///< tiles not handed out, for the first time and again
    std::exception_ptr m_failure;
    std::vector<Failure> m_failures;  ///< none twice
    std::size_t m_given_back = 0;     ///< bands of who was lost just now
    Clock::time_point m_alone_since, m_told;
    bool m_alone = true;
    std::uint64_t m_random;
    Counts m_counts;
    MemberId m_next_id = 1;
    bool m_closed = false, m_cancelled = false, m_has_checker = false;
    bool m_stands_in = false;  ///< the processor of make_checker traces whatever is to do
};

}  // namespace terravox::processors
