#include "raytracer/farm/processors/lease_planner.hpp"

#include <algorithm>

namespace terravox::processors {
namespace {

using Seconds = std::chrono::duration<double>;

/// Duration of the work that a member has leased at once: many times the round-trip time.
constexpr double kWindow_s = 0.3;
/// A smaller band costs more to transfer than to compute.
constexpr std::size_t kMinBand = 1024;
/// With layers a band of this many pixels has some 13 MB, which fit a frame.
constexpr std::size_t kMaxBand = 65'536;
/// Assumed speed of a thread of this process whose speed is unknown.
constexpr std::size_t kFirstBand = 4096;
/// Upper bound of an expected duration, so that no deadline overflows.
constexpr double kMaxExpected_s = 86'400;
/// Expected duration of a band for a member of unknown speed.
constexpr double kUnknownBand_s = 0.1;

}  // namespace

std::vector<LeasePlanner::Grant> LeasePlanner::plan(Time now, bool checks_only) {
    std::vector<Grant> out;
    if (!checks_only)
        reassign_returned(now, out);
    m_returned = 0;
    for (auto& [id, member] : m_members.all()) {
        if (member.spec().trusted)
            plan_checks(id, member, now, out);
        if (!checks_only && m_members.takes_work(member))
            plan_member(id, member, now, out);
    }
    return out;
}

// Returned bands are leased at once to the members that will finish first, however much these have
// leased already.
void LeasePlanner::reassign_returned(Time now, std::vector<Grant>& out) {
    for (; m_returned > 0; --m_returned) {
        const MemberId id = first_to_be_done();
        if (id == 0)
            return;
        const auto band = m_book.lease(id, kMaxBand, now);
        if (!band)
            return;
        grant(id, *m_members.find(id), *band, now, out);
    }
}

/// @return of the members without a limit of leases, the one that will finish first; 0: there is
/// none
MemberId LeasePlanner::first_to_be_done() const {
    MemberId best = 0;
    double best_s = 0;
    for (const auto& [id, member] : m_members.all()) {
        // Threads of this process have a bounded queue.
        if (!m_members.takes_work(member) || member.is_on_probation() || member.spec().trusted ||
            member.pixels_per_s() <= 0)
            continue;
        const double left_s =
            static_cast<double>(m_book.measure_load(id).pixels) / member.pixels_per_s();
        if (best == 0 || left_s < best_s) {
            best = id;
            best_s = left_s;
        }
    }
    return best;
}

void LeasePlanner::plan_checks(MemberId id, PoolMember& member, Time now, std::vector<Grant>& out) {
    const std::size_t max_leases = member.max_leases();
    while (m_book.checks_wait() && m_book.measure_load(id).leases < max_leases)
        if (const auto band = m_book.lease_check(id, now))
            grant(id, member, *band, now, out);
}

void LeasePlanner::plan_member(MemberId id, PoolMember& member, Time now, std::vector<Grant>& out) {
    const std::size_t max_leases = member.max_leases();
    const std::size_t threads = member.threads();
    const std::size_t wanted = wanted_pixels(member);
    // Several bands for each thread, so that none waits for the others at the end.
    const std::size_t size = std::clamp(wanted / (threads * 2), kMinBand, kMaxBand);
    while (true) {
        const LeaseBook::Load load = m_book.measure_load(id);
        // One band more than it has threads hides the latency, however small the bands are.
        const bool has_enough = load.pixels >= wanted && load.leases > threads;
        const bool must_answer = member.is_on_probation() && load.leases > 0;
        if (load.leases >= max_leases || has_enough || must_answer)
            return;
        if (const auto band = m_book.lease(id, size, now))
            grant(id, member, *band, now, out);
        else if (load.leases >= threads || !repeat_lease(id, member, now, out))
            return;
    }
}

std::size_t LeasePlanner::wanted_pixels(const PoolMember& member) const {
    const std::size_t threads = member.threads();
    const bool trusted = member.spec().trusted;
    const double speed = member.pixels_per_s();
    // Threads of this process put tiles aside that wait for boxes, so they can use more. A worker's
    // leases are lost with it.
    const std::size_t at_first = threads * (trusted ? kFirstBand * 6 : kMinBand * 2);
    if (speed <= 0)
        return at_first;
    const double hidden = speed * (kWindow_s + 2 * member.latency_s());
    const double window = trusted ? std::max(hidden, static_cast<double>(at_first)) : hidden;
    // Half of its share of what is left to do: the other half stays for those that turn out to be
    // faster.
    const auto left = static_cast<double>(m_book.pending_pixels() + m_book.leased_pixels());
    const double half_share = left * speed / std::max(m_members.pixels_per_s(), speed) / 2;
    const double share = std::max(half_share, static_cast<double>(threads * kMinBand));
    return static_cast<std::size_t>(std::min(window, share));
}

bool LeasePlanner::repeat_lease(MemberId id, PoolMember& member, Time now,
                                std::vector<Grant>& out) {
    const auto open = m_book.open_leases();
    const LeaseBook::Open* best = nullptr;
    double best_left_s = 0;
    for (const LeaseBook::Open& lease : open) {
        if (lease.member == id || !lease.alone || m_book.has(id, lease.band))
            continue;
        const auto left_s = worthwhile_left_s(lease, member, now);
        if (left_s && (best == nullptr || *left_s > best_left_s)) {
            best = &lease;
            best_left_s = *left_s;
        }
    }
    if (best == nullptr)
        return false;
    grant(id, member, m_book.lease_again(id, best->band, now), now, out);
    out.back().repeated = true;
    return true;
}

/// @return expected seconds until the owner of a lease has finished it; nullopt if repeating it is
/// not worthwhile, as the member would not finish much sooner
std::optional<double> LeasePlanner::worthwhile_left_s(const LeaseBook::Open& lease,
                                                      const PoolMember& member, Time now) const {
    const PoolMember* owner = m_members.find(lease.member);
    if (owner == nullptr)
        return std::nullopt;
    const double passed_s = Seconds(now - lease.given).count();
    const double owner_speed = owner->pixels_per_s();
    double left_s = std::max(1.0, passed_s);
    if (owner_speed > 0) {
        const auto load = static_cast<double>(m_book.measure_load(lease.member).pixels);
        left_s = load / owner_speed - passed_s * 0.5;
    }
    const double speed = member.pixels_per_s();
    const double own_s = speed > 0 ? static_cast<double>(lease.pixels) / speed : kUnknownBand_s;
    if (std::max(left_s, passed_s) < 1.5 * own_s + 0.02)
        return std::nullopt;
    return left_s;
}

LeasePlanner::Time LeasePlanner::find_deadline(MemberId id, const PoolMember& member,
                                               Time now) const {
    const double speed = member.pixels_per_s();
    const auto load = static_cast<double>(m_book.measure_load(id).pixels);
    const double expected_s = speed > 0 ? std::min(3 * load / speed, kMaxExpected_s) : 0;
    const auto expected = std::chrono::duration_cast<Time::duration>(Seconds(expected_s));
    return now + std::max<Time::duration>(m_min_deadline, expected);
}

void LeasePlanner::grant(MemberId id, PoolMember& member, const tiles::RenderTile& band, Time now,
                         std::vector<Grant>& out) {
    member.on_lease(now);
    if (!member.spec().trusted)
        m_book.set_deadline(id, band, find_deadline(id, member, now));
    out.push_back({id, member.spec().processor, band, false});
}

}  // namespace terravox::processors
