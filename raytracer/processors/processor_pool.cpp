#include "raytracer/processors/processor_pool.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "common/thread/start_threads.hpp"
#include "raytracer/tiles/tile_codec.hpp"

namespace terravox::processors {
namespace {

using std::chrono::milliseconds;

constexpr double kWindow_s =
    0.3;  // work under way at a member: what its results take to come and go many times over
constexpr double kForget_s = 4;  // half of what a speed remembers
constexpr std::size_t kMinBand =
    1024;  // pixels: below, a band costs more on its way than it is worth
constexpr std::size_t kMaxBand = 65'536;  // with layers some 13 MB, which a frame holds
constexpr std::size_t kMaxReady = 1024;   // tiles that nobody has taken yet
constexpr std::size_t kFirstBand = 4096;  // of a thread of this process
constexpr std::size_t kMaxFailures = 3;   // a band that so many members cannot trace nobody can
constexpr milliseconds kTick{100};
constexpr milliseconds kSlice{10};

double seconds(std::chrono::steady_clock::duration d) noexcept {
    return std::chrono::duration<double>(d).count();
}

bool share_rows(const tiles::RenderTile& a, const tiles::RenderTile& b) noexcept {
    return a.index == b.index && a.y0 < b.y1 && b.y0 < a.y1;
}

}  // namespace

ProcessorPool::ProcessorPool(PoolSettings settings)
    : m_settings(std::move(settings)),
      m_alone_since(Clock::now()),
      m_told(m_alone_since),
      m_random(m_settings.seed | 1) {}

ProcessorPool::~ProcessorPool() {
    cancel();
    std::vector<std::thread> threads;
    {
        const std::lock_guard lock(m_mutex);
        for (auto& [id, member] : m_members)
            if (member->pump.joinable())
                threads.push_back(std::move(member->pump));
        for (auto& member : m_leaving)
            if (member->pump.joinable())
                threads.push_back(std::move(member->pump));
    }
    for (std::thread& t : threads)
        t.join();
}

int ProcessorPool::capacity() const noexcept {
    return std::numeric_limits<int>::max();
}  // it must know all that is to do, so that all end together

ProcessorPool::MemberId ProcessorPool::add(Member member) {
    MemberId id = 0;
    {
        const std::lock_guard lock(m_mutex);
        auto state = std::make_unique<State>();
        state->is = std::move(member);
        state->paused = state->is.paused;
        id = begin_member(std::move(state));
        m_alone = false;
    }
    feed();
    return id;
}

// With the lock held, for which its thread waits before it touches anything.
ProcessorPool::MemberId ProcessorPool::begin_member(std::unique_ptr<State> state) {
    const MemberId id = m_next_id++;
    state->since = state->mark = Clock::now();
    State& member = *m_members.emplace(id, std::move(state)).first->second;
    if (member.is.on_caller)
        return id;
    try {
        member.pump = thread::start_thread(
            "the results of a processor",
            [this, id, processor = member.is.processor] { pump(id, processor); });
    } catch (...) {
        m_members.erase(id);
        throw;
    }
    return id;
}

void ProcessorPool::remove(MemberId id, const std::string& why) {
    left(id, why, false);
}

void ProcessorPool::drain(MemberId id, const std::vector<tiles::RenderTile>& given_back) {
    {
        const std::lock_guard lock(m_mutex);
        const auto found = m_members.find(id);
        if (found == m_members.end())
            return;
        found->second->draining = true;
        for (const tiles::RenderTile& band : given_back)
            m_book.give_back(id, band);
        m_counts.given_back += given_back.size();
    }
    feed();
}

void ProcessorPool::pause(MemberId id, bool on) {
    {
        const std::lock_guard lock(m_mutex);
        if (const auto found = m_members.find(id); found != m_members.end())
            found->second->paused = on;
    }
    feed();
}

void ProcessorPool::submit(tiles::RenderTile tile) {
    {
        const std::lock_guard lock(m_mutex);
        if (m_closed)
            return;
        const std::uint64_t key = std::uint64_t{tile.pass} << 32 | tile.first_sample;
        // What is to be mended is in the mean of an earlier pass by now.
        if (m_pass_key != key && m_again_left > 0 && !m_failure)
            m_failure = std::make_exception_ptr(
                PictureInvalidated("render: a worker was not to be trusted"));
        if (m_failure)
            return;
        if (std::exchange(m_pass_key, key) != key)
            m_handed.clear();
        m_book.add(tile);
        ++m_first_left;
    }
    // Not yet: who works is fed when the caller asks for answers, and knows then of all that it has
    // submitted.
}

bool ProcessorPool::can_hand_out() const noexcept {
    if (m_ready.empty())
        return false;
    // The last is kept back until nothing can make us mend another: with it the picture ends.
    return m_ready.front().again || m_first_left > 1 ||
           (m_book.open_checks() == 0 && m_again_left == 0);
}

bool ProcessorPool::has_answer() const noexcept {
    return m_failure || m_cancelled || can_hand_out() ||
           (m_closed && m_first_left == 0 && m_again_left == 0);
}

bool ProcessorPool::wait(milliseconds most) {
    const auto until = Clock::now() + most;
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
    if (m_cancelled || !can_hand_out())
        return std::nullopt;
    tiles::TileResult result = std::move(m_ready.front());
    m_ready.pop_front();
    if (m_handed.insert(result.tile.index).second)
        --m_first_left;
    else {
        --m_again_left;
        ++m_counts.mended;
    }
    return result;
}

std::vector<std::uint32_t> ProcessorPool::take_invalidated() {
    const std::lock_guard lock(m_mutex);
    return std::exchange(m_doubted, {});
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
        for (auto& [id, member] : m_members)
            processors.push_back(member->is.processor);
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
        if (!m_failure)
            m_failure = std::current_exception();
        m_done.notify_all();
        return;
    }
    left(id, why, expelled, failed ? &*failed : nullptr);
}

void ProcessorPool::run_green(Clock::time_point until) {
    std::vector<std::pair<MemberId, std::shared_ptr<TileProcessor>>> green;
    {
        const std::lock_guard lock(m_mutex);
        for (const auto& [id, member] : m_members)
            if (member->is.on_caller && !member->gone)
                green.emplace_back(id, member->is.processor);
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

bool ProcessorPool::to_check(State& member) {
    if (member.is.trusted || m_settings.check_every <= 0)
        return false;
    if (member.answers == 0 || std::exchange(member.check_next, false))
        return true;
    return next_random() % static_cast<std::uint64_t>(m_settings.check_every) == 0;
}

// The rows of a band that are made again: as few as keep blocks of pixels whole, anywhere.
tiles::RenderTile ProcessorPool::rows_to_check(tiles::RenderTile band) {
    const int grain = LeaseBook::kMinRows * band.step, begin = band.y0 / grain,
              parts = (band.y1 + grain - 1) / grain - begin;
    const int chosen =
        begin + static_cast<int>(next_random() % static_cast<std::uint64_t>(std::max(parts, 1)));
    band.y0 = std::max(band.y0, chosen * grain);
    band.y1 = std::min(band.y1, (chosen + 1) * grain);
    return band;
}

// Ref: Marsaglia, "Xorshift RNGs", 2003.
std::uint64_t ProcessorPool::next_random() noexcept {
    m_random ^= m_random << 13;
    m_random ^= m_random >> 7;
    m_random ^= m_random << 17;
    return m_random;
}

bool ProcessorPool::accept(MemberId id, tiles::TileResult&& result) {
    std::vector<Withdrawal> withdrawals;
    std::string doubt;
    MemberId doubted = 0;
    {
        std::unique_lock lock(m_mutex);
        if (m_cancelled)
            return false;
        const auto found = m_members.find(id);
        if (found == m_members.end())
            return false;
        State& member = *found->second;
        const tiles::RenderTile band = result.tile;
        const bool checks = to_check(member);
        const tiles::RenderTile checked = checks ? rows_to_check(band) : band;
        const std::uint64_t hash = checks ? tiles::hash_of_pixels(result, checked) : 0;
        LeaseBook::Holes holes = checks ? result.holes : LeaseBook::Holes();
        const auto now = Clock::now();
        count_time(member, now);
        LeaseBook::Taken taken = m_book.take(id, std::move(result));
        using Answer = LeaseBook::Answer;
        spdlog::debug("answer: tile {} rows {} to {} step {} sample {} of {}", band.index, band.y0,
                      band.y1, band.step, band.first_sample, member.is.name);
        if (taken.answer == Answer::kUnasked) {
            ++m_counts.unasked;
        } else {
            member.late = member.doubtful = false;
            // Until its first answer a worker makes itself ready: that says nothing of its speed.
            if (!std::exchange(member.started, true) && !member.is.trusted)
                member.recent_s = 0;
            else
                member.recent_pixels += static_cast<double>(taken.pixels);
        }
        switch (taken.answer) {
            case Answer::kFirst:
                ++member.bands;
                ++member.answers;
                member.pixels += taken.pixels;
                if (checks)
                    m_book.check(id, checked, hash, std::move(holes));
                for (const MemberId other : taken.withdraw)
                    if (const auto at = m_members.find(other); at != m_members.end())
                        withdrawals.push_back({at->second->is.processor, band});
                if (taken.whole) {
                    taken.whole->again = m_handed.contains(taken.whole->tile.index);
                    m_ready.push_back(std::move(*taken.whole));
                    // What mends goes first: the last of the others may have to wait for it.
                    if (m_ready.back().again)
                        std::rotate(m_ready.begin(), m_ready.end() - 1, m_ready.end());
                }
                break;
            case Answer::kLate: ++m_counts.late; break;
            case Answer::kUnequal: {
                // One of two that are not both to be trusted is wrong: who is, a third one says.
                const auto other = m_members.find(taken.other);
                const bool other_trusted = other != m_members.end() && other->second->is.trusted;
                if (member.is.trusted) {
                    if (LeaseBook::is_comparable(taken.other_holes, taken.holes))
                        doubted = taken.other;
                } else if (other_trusted) {
                    if (LeaseBook::is_comparable(taken.holes, taken.other_holes))
                        doubted = id;
                } else {
                    m_book.check(taken.other, band, taken.other_hash, std::move(taken.other_holes));
                    m_book.check(id, band, taken.hash, std::move(taken.holes));
                }
                doubt = "it disagrees with another about rows " + std::to_string(band.y0) + " to " +
                        std::to_string(band.y1) + " of tile " + std::to_string(band.index);
                break;
            }
            case Answer::kChecked: ++m_counts.checked; break;
            case Answer::kUndecided:
                if (const auto other = m_members.find(taken.other); other != m_members.end())
                    other->second->check_next = true;
                break;
            case Answer::kFalse:
                ++m_counts.checked;
                doubted = taken.other;
                doubt = "its pixels of rows " + std::to_string(band.y0) + " to " +
                        std::to_string(band.y1) + " of tile " + std::to_string(band.index) +
                        " are wrong";
                break;
            case Answer::kUnasked: break;
        }
        if (m_book.checks_wait())
            need_checker(lock);
        if (has_answer())
            m_done.notify_all();
    }
    for (const Withdrawal& w : withdrawals)
        w.from->withdraw(w.band);
    if (doubted != 0)
        left(doubted, doubt, true);
    feed();
    return true;
}

void ProcessorPool::need_checker(std::unique_lock<std::mutex>& lock) {
    if (m_has_checker || !m_settings.make_checker)
        return;
    for (const auto& [id, member] : m_members)
        if (member->is.trusted && !member->gone)
            return;
    m_has_checker = true;
    lock.unlock();
    Member checker{"checks", "threads", 1, true, false, m_settings.make_checker(), {}};
    lock.lock();
    if (m_cancelled) {
        checker.processor->cancel();
        return;
    }
    auto state = std::make_unique<State>();
    state->is = std::move(checker);
    state->checks_only = true;
    begin_member(std::move(state));
}

bool ProcessorPool::takes_work(const State& member) const noexcept {
    const bool wanted = !member.checks_only || m_stands_in;
    return wanted && !member.draining && !member.paused && !member.late && !member.gone;
}

// Whether somebody of this process tries all that others cannot trace.
bool ProcessorPool::traces_here() const noexcept {
    return m_stands_in || std::any_of(m_members.begin(), m_members.end(), [this](const auto& m) {
               return m.second->is.trusted && takes_work(*m.second);
           });
}

// Bands are cut anew when they go to others, so it is rows that are compared.
void ProcessorPool::note_failure(MemberId id, const State& member, const tiles::RenderTile& band,
                                 const std::string& why) {
    if (band.step == 0)
        return;  // the picture as a whole: others say more of each band
    const std::string who = member.is.who.empty() ? "member " + std::to_string(id) : member.is.who;
    const auto is_known = [&](const Failure& f) { return f.who == who && f.band == band; };
    if (std::none_of(m_failures.begin(), m_failures.end(), is_known))
        m_failures.push_back({band, who});
    std::set<std::string> different;
    for (const Failure& f : m_failures)
        if (share_rows(f.band, band))
            different.insert(f.who);
    if (different.size() < kMaxFailures || traces_here() || m_failure)
        return;
    m_failure = std::make_exception_ptr(
        util::Error("render: " + std::to_string(different.size()) + " workers failed at rows " +
                    std::to_string(band.y0) + " to " + std::to_string(band.y1) + " of tile " +
                    std::to_string(band.index) + "; the last said: " + why));
}

// All that were there have failed. Whether it is they or the picture, this process finds out.
void ProcessorPool::stand_in(std::unique_lock<std::mutex>& lock, const std::string& why) {
    if (m_failure || m_cancelled || m_stands_in)
        return;
    if (!m_settings.make_checker) {
        m_failure = std::make_exception_ptr(
            util::Error("render: all workers failed; the last said: " + why));
        return;
    }
    m_stands_in = true;
    spdlog::warn("every worker has failed; this machine goes on with one thread");
    try {
        need_checker(lock);
    } catch (...) {
        if (!lock.owns_lock())
            lock.lock();
        if (!m_failure)
            m_failure = std::current_exception();
    }
}

void ProcessorPool::left(MemberId id, const std::string& why, bool expelled,
                         const tiles::RenderTile* failed) {
    std::shared_ptr<TileProcessor> processor;
    {
        std::unique_lock lock(m_mutex);
        const auto found = m_members.find(id);
        if (found == m_members.end() && !expelled)
            return;
        if (found != m_members.end()) {
            processor = found->second->is.processor;
            found->second->gone = true;
            if (failed != nullptr)
                note_failure(id, *found->second, *failed, why);
            m_leaving.push_back(std::move(found->second));
            m_members.erase(found);
            ++(expelled ? m_counts.expelled : m_counts.lost);
        }
        if (expelled) {
            const bool merged =
                (m_pass_key & 0xffffffffU) != 0;  // samples are in the mean of earlier ones already
            // Of those that were not handed out the new one takes the old one's place.
            for (const std::uint32_t index : m_book.revoke(id))
                if (std::erase_if(m_ready, [&](const tiles::TileResult& r) {
                        return r.tile.index == index;
                    }) == 0) {
                    ++m_again_left;
                    m_doubted.push_back(index);
                }
            if ((m_book.spoiled_earlier(id) || (merged && m_again_left > 0)) && !m_failure)
                m_failure = std::make_exception_ptr(
                    PictureInvalidated("render: a worker is not to be trusted (" + why + ")"));
        } else {
            const std::size_t bands = m_book.give_back(id);
            m_given_back += bands;
            m_counts.given_back += bands;
        }
        m_alone = std::none_of(m_members.begin(), m_members.end(),
                               [](const auto& m) { return !m.second->checks_only; });
        if (m_alone) {
            m_alone_since = Clock::now();
            m_told = {};
        }
        if (failed != nullptr && m_alone)
            stand_in(lock, why);
        m_done.notify_all();
    }
    if (processor)
        processor->cancel();
    if (m_settings.gone)
        m_settings.gone(id, why, expelled);
    feed();
}

double ProcessorPool::all_speeds() const noexcept {
    double sum = 0;
    for (const auto& [id, member] : m_members)
        if (takes_work(*member))
            sum += member->speed();
    return sum;
}

std::size_t ProcessorPool::wanted_pixels(const State& member) const {
    const auto threads = static_cast<std::size_t>(std::max(member.is.threads, 1));
    const double speed = member.speed();
    // Threads of this process lay tiles aside that wait for boxes: they have use for more. What a
    // worker holds is lost with it.
    const std::size_t least = threads * (member.is.trusted ? kFirstBand * 6 : kMinBand * 2);
    if (speed <= 0)
        return least;
    const double latency_s = member.is.latency_s ? member.is.latency_s() : 0;
    const double hidden = speed * (kWindow_s + 2 * latency_s);
    // Half of its share of what is left to do: the other half stays for who turns out to be faster.
    const auto left = static_cast<double>(m_book.pending_pixels() + m_book.leased_pixels());
    const double share = std::max(left * speed / std::max(all_speeds(), speed) / 2,
                                  static_cast<double>(threads * kMinBand));
    return static_cast<std::size_t>(
        std::min(member.is.trusted ? std::max(hidden, static_cast<double>(least)) : hidden, share));
}

void ProcessorPool::lease_to(MemberId id, State& member, const tiles::RenderTile& band,
                             Clock::time_point now, std::vector<Dispatch>& out) {
    if (!std::exchange(member.busy, true))
        member.mark = now;
    if (!member.is.trusted) {
        const double speed = member.speed();
        const auto load = static_cast<double>(m_book.load_of(id).pixels);
        const double expected_s = speed > 0 ? 3 * load / speed : 0;
        m_book.set_deadline(
            id, band,
            now + std::max<Clock::duration>(
                      m_settings.min_deadline,
                      std::chrono::duration_cast<Clock::duration>(
                          std::chrono::duration<double>(std::min(expected_s, 86400.0)))));
    }
    // Read by the benches that break farms: rows, so that a band cut anew is known again.
    spdlog::debug("lease: tile {} rows {} to {} step {} sample {} to {}", band.index, band.y0,
                  band.y1, band.step, band.first_sample, member.is.name);
    out.push_back({member.is.processor, band});
}

bool ProcessorPool::give_again(MemberId id, State& member, Clock::time_point now,
                               std::vector<Dispatch>& out) {
    const LeaseBook::Open* best = nullptr;
    double best_left_s = 0;
    const auto open = m_book.open_leases();
    for (const auto& lease : open) {
        if (lease.member == id || !lease.alone || m_book.has(id, lease.band))
            continue;
        const auto owner = m_members.find(lease.member);
        if (owner == m_members.end())
            continue;
        const double speed = owner->second->speed(),
                     load = static_cast<double>(m_book.load_of(lease.member).pixels);
        const double left_s = speed > 0 ? load / speed - seconds(now - lease.given) * 0.5
                                        : std::max(1.0, seconds(now - lease.given));
        const double own_s =
            member.speed() > 0 ? static_cast<double>(lease.pixels) / member.speed() : 0.1;
        // An owner that will have it done about as soon is left alone.
        if (std::max(left_s, seconds(now - lease.given)) < 1.5 * own_s + 0.02)
            continue;
        if (best == nullptr || left_s > best_left_s) {
            best = &lease;
            best_left_s = left_s;
        }
    }
    if (best == nullptr)
        return false;
    lease_to(id, member, m_book.lease_again(id, best->band, now), now, out);
    ++m_counts.second;
    return true;
}

void ProcessorPool::plan_member(MemberId id, State& member, Clock::time_point now,
                                std::vector<Dispatch>& out) {
    const auto max_leases = static_cast<std::size_t>(std::max(member.is.processor->capacity(), 1));
    if (member.is.trusted)
        while (m_book.checks_wait() && m_book.load_of(id).leases < max_leases)
            if (auto band = m_book.lease_check(id, now))
                lease_to(id, member, *band, now, out);
    // Who takes tiles is slower than all who make them: they wait, and memory stays bounded.
    if (!takes_work(member) || m_ready.size() > kMaxReady)
        return;
    const auto threads = static_cast<std::size_t>(std::max(member.is.threads, 1));
    const std::size_t wanted = wanted_pixels(member);
    while (true) {
        const auto load = m_book.load_of(id);
        // One more than it has threads hides the way, however small they are.
        if (load.leases >= max_leases || (load.pixels >= wanted && load.leases > threads) ||
            (member.doubtful && load.leases > 0))
            return;
        // Several for each thread, so that none waits for the others at the end.
        const std::size_t size = std::clamp(wanted / (threads * 2), kMinBand, kMaxBand);
        if (auto band = m_book.lease(id, size, now))
            lease_to(id, member, *band, now, out);
        else if (load.leases >= threads || !give_again(id, member, now, out))
            return;
    }
}

// What somebody has lost is given at once to who will have it done first, however much that one
// has: it need not wait for answers.
void ProcessorPool::reassign(std::size_t bands, Clock::time_point now, std::vector<Dispatch>& out) {
    for (; bands > 0 && m_ready.size() <= kMaxReady; --bands) {
        MemberId best = 0;
        double best_s = 0;
        for (const auto& [id, member] : m_members) {
            // Threads of this process have no queue without end.
            if (!takes_work(*member) || member->doubtful || member->is.trusted ||
                member->speed() <= 0)
                continue;
            const double s = static_cast<double>(m_book.load_of(id).pixels) / member->speed();
            if (best == 0 || s < best_s) {
                best = id;
                best_s = s;
            }
        }
        if (best == 0)
            return;
        const auto band = m_book.lease(best, kMaxBand, now);
        if (!band)
            return;
        lease_to(best, *m_members.at(best), *band, now, out);
    }
}

// What members have use for, handed to them.
void ProcessorPool::feed() {
    std::vector<Dispatch> handings;
    {
        const std::lock_guard lock(m_mutex);
        if (m_cancelled || m_failure)
            return;
        const auto now = Clock::now();
        reassign(std::exchange(m_given_back, 0), now, handings);
        for (auto& [id, member] : m_members)
            plan_member(id, *member, now, handings);
    }
    for (Dispatch& h : handings)
        h.to->submit(h.band);
}

void ProcessorPool::count_time(State& member, Clock::time_point now) {
    if (!member.busy)
        return;
    const double passed = seconds(now - member.mark), keep = std::exp2(-passed / kForget_s);
    member.recent_pixels *= keep;
    member.recent_s = member.recent_s * keep + passed;
    member.busy_s += passed;
    member.mark = now;
}

void ProcessorPool::tick(std::unique_lock<std::mutex>& lock) {
    const auto now = Clock::now();
    for (auto& [id, member] : m_members) {
        if (m_book.load_of(id).leases > 0)
            continue;
        member->late = false;  // others have done what it had: it may try again
        if (!member->busy)
            continue;
        count_time(*member, now);
        member->busy = false;
    }
    bool again = false;
    for (const MemberId id : m_book.expire(now)) {
        again = true;
        const auto found = m_members.find(id);
        if (found == m_members.end() || std::exchange(found->second->late, true))
            continue;
        found->second->doubtful = true;
        spdlog::warn("{} is late; others do its tiles, too", found->second->is.name);
    }
    if (m_alone && m_first_left + m_again_left > 0 && !m_closed) {
        const auto alone = now - m_alone_since;
        if (m_settings.give_up && alone > *m_settings.give_up && !m_failure)
            m_failure = std::make_exception_ptr(
                NoProcessorsLeft("render: no worker for " +
                                 std::to_string(static_cast<int>(seconds(alone))) + " s"));
        else if (alone > std::chrono::seconds(1) && now - m_told > std::chrono::seconds(10)) {
            m_told = now;
            const std::size_t tiles = m_first_left + m_again_left;
            if (m_stands_in)
                spdlog::warn("no worker: {} tiles are left to this machine", tiles);
            else
                spdlog::warn("no worker: {} tiles wait for one", tiles);
        }
    }
    lock.unlock();
    if (again)
        feed();
    // Threads of members that have left end on their own; here they are let go.
    std::vector<std::unique_ptr<State>> leaving;
    lock.lock();
    leaving.swap(m_leaving);
    lock.unlock();
    for (auto& member : leaving)
        if (member->pump.joinable() && member->pump.get_id() != std::this_thread::get_id())
            member->pump.join();
    leaving.clear();
    lock.lock();
}

std::vector<ProcessorPool::Status> ProcessorPool::status() const {
    const std::lock_guard lock(m_mutex);
    std::vector<Status> out;
    const auto now = Clock::now();
    for (const auto& [id, m] : m_members) {
        const double busy_s = m->busy_s + (m->busy ? seconds(now - m->mark) : 0),
                     here_s = std::max(seconds(now - m->since), 1e-6);
        const char* state = m->late       ? "late"
                            : m->draining ? "draining"
                            : m->paused   ? "paused"
                            : m->busy     ? "working"
                                          : "waiting";
        out.push_back({id, m->is.name, m->is.kind, state, m->is.threads, m->bands, m->pixels,
                       m->speed(), m->is.latency_s ? m->is.latency_s() : 0,
                       std::min(busy_s / here_s, 1.0), m_book.load_of(id).leases});
    }
    return out;
}

ProcessorPool::Counts ProcessorPool::counts() const {
    const std::lock_guard lock(m_mutex);
    return m_counts;
}

}  // namespace terravox::processors
