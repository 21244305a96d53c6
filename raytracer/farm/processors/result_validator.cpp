#include "raytracer/farm/processors/result_validator.hpp"

#include <utility>

#include "raytracer/core/tiles/tile_codec.hpp"

namespace terravox::processors {
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
