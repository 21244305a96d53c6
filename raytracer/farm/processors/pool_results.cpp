#include "raytracer/farm/processors/pool_results.hpp"

#include <algorithm>
#include <set>
#include <utility>

#include "raytracer/core/tiles/tile_codec.hpp"

namespace terravox::processors {

void ResultQueue::expect(const tiles::RenderTile& tile) {
    if (begins_pass(tile))
        m_taken.clear();
    m_pass = to_pass(tile);
    ++m_first_left;
}

void ResultQueue::push(tiles::TileResult&& result) {
    result.again = m_taken.contains(result.tile.index);
    // Tiles that are returned again are first, as the last of the others may have to wait for them.
    if (result.again)
        m_ready.push_front(std::move(result));
    else
        m_ready.push_back(std::move(result));
}

bool ResultQueue::can_take(bool checks_open) const noexcept {
    if (m_ready.empty())
        return false;
    return m_ready.front().again || m_first_left > 1 || (!checks_open && m_again_left == 0);
}

tiles::TileResult ResultQueue::take() {
    tiles::TileResult result = std::move(m_ready.front());
    m_ready.pop_front();
    if (m_taken.insert(result.tile.index).second)
        --m_first_left;
    else
        --m_again_left;
    return result;
}

void ResultQueue::invalidate(std::uint32_t index) {
    // If the tile was not taken, the new result replaces the old one.
    const auto is_it = [&](const tiles::TileResult& r) { return r.tile.index == index; };
    if (std::erase_if(m_ready, is_it) > 0)
        return;
    ++m_again_left;
    m_invalidated.push_back(index);
}

namespace {

bool share_rows(const tiles::RenderTile& a, const tiles::RenderTile& b) noexcept {
    return a.index == b.index && a.y0 < b.y1 && b.y0 < a.y1;
}

}  // namespace

std::size_t FailureLog::add(const tiles::RenderTile& band, const std::string& identity) {
    const auto is_known = [&](const Failure& f) {
        return f.identity == identity && f.band == band;
    };
    if (std::none_of(m_failures.begin(), m_failures.end(), is_known))
        m_failures.push_back({band, identity});
    std::set<std::string> different;
    for (const Failure& f : m_failures)
        if (share_rows(f.band, band))
            different.insert(f.identity);
    return different.size();
}

bool CheckPolicy::is_due(PoolMember& member) noexcept {
    if (member.spec().trusted || m_check_every <= 0)
        return false;
    if (member.bands() == 0 || member.take_check_request())
        return true;
    return next_random() % static_cast<std::uint64_t>(m_check_every) == 0;
}

tiles::RenderTile CheckPolicy::choose_rows(tiles::RenderTile band) noexcept {
    const int grain = LeaseBook::kMinRows * band.step;
    const int first = band.y0 / grain;
    const int parts = (band.y1 + grain - 1) / grain - first;
    const auto choices = static_cast<std::uint64_t>(std::max(parts, 1));
    const int chosen = first + static_cast<int>(next_random() % choices);
    band.y0 = std::max(band.y0, chosen * grain);
    band.y1 = std::min(band.y1, (chosen + 1) * grain);
    return band;
}

// Ref: Marsaglia, "Xorshift RNGs", 2003.
std::uint64_t CheckPolicy::next_random() noexcept {
    m_random ^= m_random << 13;
    m_random ^= m_random >> 7;
    m_random ^= m_random << 17;
    return m_random;
}

namespace {

std::string name_of_rows(const tiles::RenderTile& band) {
    return "rows " + std::to_string(band.y0) + " to " + std::to_string(band.y1) + " of tile " +
           std::to_string(band.index);
}

}  // namespace

ResultValidator::Verdict ResultValidator::validate(MemberId id, PoolMember& member,
                                                   tiles::TileResult&& result, Time now) {
    using Answer = LeaseBook::Answer;
    const tiles::RenderTile band = result.tile;
    std::optional<Check> check = choose_check(member, result);
    member.count_time(now);
    LeaseBook::Taken taken = m_book.take(id, std::move(result));
    if (taken.answer != Answer::kUnrequested)
        member.on_answer(taken.pixels);
    Verdict out;
    out.answer = taken.answer;
    switch (taken.answer) {
        case Answer::kFirst:
            member.add_band(taken.pixels);
            if (check)
                m_book.check(id, check->rows, check->hash, std::move(check->holes));
            for (const MemberId other : taken.withdraw)
                if (const PoolMember* at = m_members.find(other))
                    out.withdraw_from.push_back(at->spec().processor);
            out.whole = std::move(taken.whole);
            break;
        case Answer::kUnequal:
            out.untrusted = settle_unequal(id, member, band, std::move(taken));
            out.reason = "it disagrees with another about " + name_of_rows(band);
            break;
        case Answer::kFalse:
            out.untrusted = taken.other;
            out.reason = "its pixels of " + name_of_rows(band) + " are wrong";
            break;
        case Answer::kUndecided:
            if (PoolMember* other = m_members.find(taken.other))
                other->request_check();
            break;
        case Answer::kLate:
        case Answer::kChecked:
        case Answer::kUnrequested: break;
    }
    return out;
}

std::optional<ResultValidator::Check> ResultValidator::choose_check(
    PoolMember& member, const tiles::TileResult& result) {
    if (!m_policy.is_due(member))
        return std::nullopt;
    Check out;
    out.rows = m_policy.choose_rows(result.tile);
    out.hash = tiles::hash_of_pixels(result, out.rows);
    out.holes = result.holes;
    return out;
}

/// One of two members that are not both trusted is wrong.
/// @return that member; 0 while this is undecided: a third member then computes the band
MemberId ResultValidator::settle_unequal(MemberId id, const PoolMember& member,
                                         const tiles::RenderTile& band, LeaseBook::Taken&& taken) {
    const PoolMember* other = m_members.find(taken.other);
    if (member.spec().trusted)
        return LeaseBook::is_comparable(taken.other_holes, taken.holes) ? taken.other : 0;
    if (other != nullptr && other->spec().trusted)
        return LeaseBook::is_comparable(taken.holes, taken.other_holes) ? id : 0;
    m_book.check(taken.other, band, taken.other_hash, std::move(taken.other_holes));
    m_book.check(id, band, taken.hash, std::move(taken.holes));
    return 0;
}

}  // namespace terravox::processors
