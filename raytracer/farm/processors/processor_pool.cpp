#include "raytracer/farm/processors/processor_pool.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "common/thread/start_threads.hpp"
#include "common/util/log.hpp"

namespace terravox::processors {
namespace {

using std::chrono::milliseconds;

/// Interval of the checks for deadlines and absent members.
constexpr milliseconds kTick{100};
/// Time slice of a member that works on the caller's thread.
constexpr milliseconds kSlice{10};

}  // namespace

ProcessorPool::ProcessorPool(PoolSettings settings)
    : m_settings(std::move(settings)),
      m_planner(m_book, m_members, m_settings.min_deadline),
      m_validator(m_book, m_members, CheckPolicy(m_settings.check_every, m_settings.seed)),
      m_watchdog(m_settings.give_up, Clock::now()) {}

ProcessorPool::~ProcessorPool() {
    cancel();
    std::map<MemberId, Pump> pumps;
    {
        const std::lock_guard lock(m_mutex);
        pumps.swap(m_pumps);
    }
    for (auto& [id, entry] : pumps)
        if (entry.thread.joinable())
            entry.thread.join();
}

// The book must know all tiles, so that all members end together.
int ProcessorPool::capacity() const noexcept {
    return std::numeric_limits<int>::max();
}

ProcessorPool::MemberId ProcessorPool::add(Member member) {
    MemberId id = 0;
    {
        const std::lock_guard lock(m_mutex);
        id = begin_member(std::move(member), false);
        m_watchdog.set_present(Clock::now());
    }
    feed();
    return id;
}

// The lock must be held; the new thread waits for it before it accesses anything.
ProcessorPool::MemberId ProcessorPool::begin_member(Member member, bool checks_only) {
    const MemberId id = m_members.add(member, checks_only, Clock::now());
    try {
        Pump& entry = m_pumps[id];
        entry.member = std::move(member);
        if (entry.member.on_caller)
            return id;
        entry.thread = thread::start_thread(
            "the results of a processor",
            [this, id, processor = entry.member.processor] { pump(id, processor); });
    } catch (...) {
        m_pumps.erase(id);
        m_members.remove(id);
        throw;
    }
    return id;
}

void ProcessorPool::drain(MemberId id, const std::vector<tiles::RenderTile>& given_back) {
    {
        const std::lock_guard lock(m_mutex);
        PoolMember* member = m_members.find(id);
        if (member == nullptr)
            return;
        member->drain();
        for (const tiles::RenderTile& band : given_back)
            m_book.give_back(id, band);
        m_counts.given_back += given_back.size();
    }
    feed();
}

void ProcessorPool::pause(MemberId id, bool on) {
    {
        const std::lock_guard lock(m_mutex);
        if (PoolMember* member = m_members.find(id))
            member->pause(on);
    }
    feed();
}

void ProcessorPool::submit(tiles::RenderTile tile) {
    {
        const std::lock_guard lock(m_mutex);
        if (m_closed)
            return;
        // The tile to mend is in the mean of an earlier pass by now.
        if (m_results.begins_pass(tile) && m_results.again_left() > 0)
            fail(
                std::make_exception_ptr(PictureInvalidated("render: a worker sent wrong results")));
        if (m_failure)
            return;
        m_book.add(tile);
        m_results.expect(tile);
    }
    // Nothing is leased yet: that happens when the caller waits for results, as all submitted tiles
    // are known by then.
}

void ProcessorPool::fail(std::exception_ptr failure) noexcept {
    if (!m_failure)
        m_failure = std::move(failure);
}

bool ProcessorPool::has_answer() const noexcept {
    return m_failure || m_cancelled || can_take() || (m_closed && m_results.tiles_left() == 0);
}

bool ProcessorPool::wait(milliseconds timeout) {
    const auto until = Clock::now() + timeout;
    feed();
    run_green(until);
    std::unique_lock lock(m_mutex);
    while (!has_answer()) {
        tick(lock);
        if (has_answer() || Clock::now() >= until)
            break;
        m_done.wait_until(lock, std::min(until, Clock::now() + kTick),
                          [&] { return has_answer(); });
    }
    return has_answer();
}

std::optional<tiles::TileResult> ProcessorPool::take() {
    while (!wait(kTick)) {
    }
    const std::lock_guard lock(m_mutex);
    if (m_failure)
        std::rethrow_exception(m_failure);
    if (m_cancelled || !can_take())
        return std::nullopt;
    tiles::TileResult result = m_results.take();
    if (result.again)
        ++m_counts.mended;
    return result;
}

std::vector<std::uint32_t> ProcessorPool::take_invalidated() {
    const std::lock_guard lock(m_mutex);
    return m_results.take_invalidated();
}

void ProcessorPool::close() noexcept {
    const std::lock_guard lock(m_mutex);
    m_closed = true;
    m_done.notify_all();
}

void ProcessorPool::cancel() noexcept {
    std::vector<std::shared_ptr<TileProcessor>> processors;
    {
        const std::lock_guard lock(m_mutex);
        m_closed = m_cancelled = true;
        for (const auto& [id, member] : m_members.all())
            processors.push_back(member.spec().processor);
        m_done.notify_all();
    }
    for (const auto& p : processors)
        p->cancel();
}

// Waits for one member's results.
void ProcessorPool::pump(MemberId id, std::shared_ptr<TileProcessor> processor) {
    std::string why;
    bool expelled = false;
    std::optional<tiles::RenderTile> failed;
    try {
        while (auto result = processor->take())
            if (!accept(id, std::move(*result)))
                return;
        why = "it ended";
    } catch (const LostProcessor& e) {
        why = e.what();
    } catch (const UntrustedProcessor& e) {
        why = e.what();
        expelled = true;
    } catch (const FailingProcessor& e) {
        why = e.what();
        failed = e.band;
    } catch (...) {
        const std::lock_guard lock(m_mutex);
        fail(std::current_exception());
        m_done.notify_all();
        return;
    }
    on_member_lost(id, why, expelled, failed ? &*failed : nullptr);
}

void ProcessorPool::run_green(Clock::time_point until) {
    std::vector<std::pair<MemberId, std::shared_ptr<TileProcessor>>> green;
    {
        const std::lock_guard lock(m_mutex);
        for (const auto& [id, member] : m_members.all())
            if (member.spec().on_caller)
                green.emplace_back(id, member.spec().processor);
    }
    if (green.empty())
        return;
    const auto answered = [&] {
        const std::lock_guard lock(m_mutex);
        return has_answer();
    };
    while (!answered() && Clock::now() < until)
        for (const auto& [id, processor] : green) {
            const auto left = std::chrono::duration_cast<milliseconds>(until - Clock::now());
            if (!processor->wait(std::clamp(left, milliseconds(0), kSlice)))
                continue;
            if (auto result = processor->take())
                (void)accept(id, std::move(*result));
        }
}

bool ProcessorPool::accept(MemberId id, tiles::TileResult&& result) {
    const tiles::RenderTile band = result.tile;
    ResultValidator::Verdict verdict;
    {
        std::unique_lock lock(m_mutex);
        if (m_cancelled)
            return false;
        PoolMember* member = m_members.find(id);
        if (member == nullptr)
            return false;
        verdict = m_validator.validate(id, *member, std::move(result), Clock::now());
        util::log_debug("answer: tile {} rows {} to {} step {} sample {} of {}", band.index,
                        band.y0, band.y1, band.step, band.first_sample, member->spec().name);
        count(verdict.answer);
        if (!member->checks_only() && verdict.answer != LeaseBook::Answer::kUnrequested)
            m_watchdog.set_answered();
        if (verdict.whole)
            m_results.push(std::move(*verdict.whole));
        if (m_book.checks_wait())
            need_checker(lock);
        if (has_answer())
            m_done.notify_all();
    }
    for (const auto& processor : verdict.withdraw_from)
        processor->withdraw(band);
    if (verdict.untrusted != 0)
        on_member_lost(verdict.untrusted, verdict.reason, true);
    feed();
    return true;
}

void ProcessorPool::count(LeaseBook::Answer answer) noexcept {
    using Answer = LeaseBook::Answer;
    if (answer == Answer::kLate)
        ++m_counts.late;
    else if (answer == Answer::kUnrequested)
        ++m_counts.unrequested;
    else if (answer == Answer::kChecked || answer == Answer::kFalse)
        ++m_counts.checked;
}

void ProcessorPool::need_checker(std::unique_lock<std::mutex>& lock) {
    if (!m_settings.make_checker || !m_members.claim_checker())
        return;
    lock.unlock();
    Member checker{"checks", "threads", 1, true, false, m_settings.make_checker(), {}};
    lock.lock();
    if (m_cancelled) {
        checker.processor->cancel();
        return;
    }
    begin_member(std::move(checker), true);
}

void ProcessorPool::note_failure(MemberId id, const Member& member, const tiles::RenderTile& band,
                                 const std::string& why) {
    if (band.step == 0)
        return;  // the picture as a whole: other members report each band
    const std::string identity =
        member.identity.empty() ? "member " + std::to_string(id) : member.identity;
    const std::size_t different = m_failures.add(band, identity);
    if (different < FailureLog::kMaxMembers || m_members.traces_here())
        return;
    fail(std::make_exception_ptr(
        util::Error("render: " + std::to_string(different) + " workers failed at rows " +
                    std::to_string(band.y0) + " to " + std::to_string(band.y1) + " of tile " +
                    std::to_string(band.index) + "; the last error: " + why)));
}

// All members have failed. This process continues, which shows whether they or the picture are at
// fault.
void ProcessorPool::stand_in(std::unique_lock<std::mutex>& lock, const std::string& why) {
    if (m_failure || m_cancelled || m_members.stands_in())
        return;
    if (!m_settings.make_checker) {
        fail(std::make_exception_ptr(
            util::Error("render: all workers failed; the last error: " + why)));
        return;
    }
    m_members.stand_in();
    util::log_warn("every worker has failed; this machine goes on with one thread");
    try {
        need_checker(lock);
    } catch (...) {
        if (!lock.owns_lock())
            lock.lock();
        fail(std::current_exception());
    }
}

void ProcessorPool::on_member_lost(MemberId id, const std::string& why, bool expelled,
                                   const tiles::RenderTile* failed) {
    std::shared_ptr<TileProcessor> processor;
    {
        std::unique_lock lock(m_mutex);
        const std::optional<PoolMember> member = m_members.remove(id);
        if (!member && !expelled)
            return;
        if (member) {
            processor = member->spec().processor;
            if (failed != nullptr)
                note_failure(id, member->spec(), *failed, why);
            ++(expelled ? m_counts.expelled : m_counts.lost);
        }
        if (expelled)
            revoke_results(id, why);
        else
            return_leases(id);
        if (m_members.has_workers())
            m_watchdog.set_present(Clock::now());
        else
            m_watchdog.set_absent(Clock::now());
        if (failed != nullptr && !m_members.has_workers())
            stand_in(lock, why);
        m_done.notify_all();
    }
    if (processor)
        processor->cancel();
    if (m_settings.gone)
        m_settings.gone(id, why, expelled);
    feed();
}

void ProcessorPool::return_leases(MemberId id) {
    const std::size_t bands = m_book.give_back(id);
    m_planner.add_returned(bands);
    m_counts.given_back += bands;
}

void ProcessorPool::revoke_results(MemberId id, const std::string& why) {
    for (const std::uint32_t index : m_book.revoke(id))
        m_results.invalidate(index);
    const bool is_beyond_mending = m_results.is_merged() && m_results.again_left() > 0;
    if (m_book.contributed_earlier(id) || is_beyond_mending)
        fail(std::make_exception_ptr(
            PictureInvalidated("render: a worker sent wrong results (" + why + ")")));
}

// Leases bands to members, and submits them.
void ProcessorPool::feed() {
    std::vector<LeasePlanner::Grant> grants;
    {
        const std::lock_guard lock(m_mutex);
        if (m_cancelled || m_failure)
            return;
        grants = m_planner.plan(Clock::now(), m_results.is_full());
        for (const LeasePlanner::Grant& g : grants) {
            if (g.repeated)
                ++m_counts.second;
            // Benchmarks that break farms read this line: it names rows, so that a band that is cut
            // anew can be recognized.
            util::log_debug("lease: tile {} rows {} to {} step {} sample {} to {}", g.band.index,
                            g.band.y0, g.band.y1, g.band.step, g.band.first_sample,
                            m_members.find(g.member)->spec().name);
        }
    }
    for (const LeasePlanner::Grant& g : grants)
        g.processor->submit(g.band);
}

void ProcessorPool::tick(std::unique_lock<std::mutex>& lock) {
    const auto now = Clock::now();
    for (auto& [id, member] : m_members.all())
        if (m_book.measure_load(id).leases == 0)
            member.on_idle(now);
    const bool has_expired = expire_leases(now);
    watch_for_members(now);
    lock.unlock();
    if (has_expired)
        feed();
    join_ended_pumps();
    lock.lock();
}

bool ProcessorPool::expire_leases(Clock::time_point now) {
    const std::vector<MemberId> late = m_book.expire(now);
    for (const MemberId id : late)
        if (PoolMember* member = m_members.find(id); member != nullptr && member->set_late())
            util::log_warn("{} is late; others do its tiles, too", member->spec().name);
    return !late.empty();
}

void ProcessorPool::watch_for_members(Clock::time_point now) {
    const std::size_t tiles = m_results.tiles_left();
    if (tiles == 0 || m_closed)
        return;
    const AbsenceWatchdog::Alarm alarm = m_watchdog.poll(now);
    if (alarm == AbsenceWatchdog::Alarm::kTimeout) {
        const auto absent =
            std::chrono::duration_cast<std::chrono::seconds>(m_watchdog.absent_for(now));
        fail(std::make_exception_ptr(
            NoProcessorsLeft("render: no worker for " + std::to_string(absent.count()) + " s")));
    } else if (alarm == AbsenceWatchdog::Alarm::kWarn) {
        if (m_members.stands_in())
            util::log_warn("no worker: {} tiles are left to this machine", tiles);
        else
            util::log_warn("no worker: {} tiles wait for one", tiles);
    }
}

// Threads of members that have left end on their own, and are joined here.
void ProcessorPool::join_ended_pumps() {
    std::map<MemberId, Pump> ended;
    {
        const std::lock_guard lock(m_mutex);
        for (auto it = m_pumps.begin(); it != m_pumps.end();) {
            const auto entry = it++;
            if (m_members.find(entry->first) == nullptr)
                ended.insert(m_pumps.extract(entry));
        }
    }
    for (auto& [id, entry] : ended)
        if (entry.thread.joinable())
            entry.thread.join();
}

std::vector<ProcessorPool::Status> ProcessorPool::status() const {
    const std::lock_guard lock(m_mutex);
    std::vector<Status> out;
    const auto now = Clock::now();
    for (const auto& [id, member] : m_members.all())
        out.push_back(member.status(id, m_book.measure_load(id).leases, now));
    return out;
}

ProcessorPool::Counts ProcessorPool::counts() const {
    const std::lock_guard lock(m_mutex);
    return m_counts;
}

}  // namespace terravox::processors
