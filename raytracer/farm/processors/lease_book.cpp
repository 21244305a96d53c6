#include "raytracer/farm/processors/lease_book.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include "raytracer/core/tiles/tile_codec.hpp"

namespace terravox::processors {
namespace {

int count_rows(const tiles::RenderTile& band) noexcept {
    return band.y1 - band.y0;
}

/// The end of a band of about this many pixels: a multiple of the minimum number of rows, so that
/// blocks of pixels stay whole.
int end_row(const tiles::RenderTile& band, std::size_t pixels) noexcept {
    const std::size_t all = LeaseBook::count_pixels(band);
    if (pixels >= all)
        return band.y1;
    const int grain = LeaseBook::kMinRows * band.step;
    const auto rows =
        static_cast<int>(static_cast<double>(count_rows(band)) * static_cast<double>(pixels) /
                         static_cast<double>(std::max<std::size_t>(all, 1)));
    const int end = (band.y0 + std::max(rows, 1) + grain - 1) / grain * grain;
    return band.y1 - end < grain ? band.y1 : end;
}

}  // namespace

std::size_t LeaseBook::count_pixels(const tiles::RenderTile& band) noexcept {
    const auto multiples = [](int begin, int end, int of) {
        return static_cast<std::size_t>(std::max((end + of - 1) / of - (begin + of - 1) / of, 0));
    };
    const auto all = [&](int of) {
        return multiples(band.x0, band.x1, of) * multiples(band.y0, band.y1, of);
    };
    return band.refines ? all(band.step) - all(2 * band.step) : all(band.step);
}

void LeaseBook::new_pass() {
    for (const auto& [index, slot] : m_slots)
        m_earlier.insert(slot.by.begin(), slot.by.end());
    m_slots.clear();
    m_units.clear();
    m_leases.clear();
    m_checks.clear();
    m_pending.clear();
    m_pending_again = m_open_checks = m_pending_pixels = m_leased_pixels = 0;
}

void LeaseBook::add(const tiles::RenderTile& tile) {
    forget_done();
    const auto same_pass = [&](const tiles::RenderTile& t) {
        return t.pass == tile.pass && t.first_sample == tile.first_sample;
    };
    if (m_unfinished == 0 && !m_slots.empty() &&
        (m_slots.contains(tile.index) || !same_pass(m_slots.begin()->second.tile)))
        new_pass();
    Slot& slot = m_slots[tile.index];
    slot = {};
    slot.tile = tile;
    slot.rows_left = count_rows(tile);
    m_pending.push_back({tile, 0});
    m_pending_pixels += count_pixels(tile);
    ++m_unfinished;
}

tiles::RenderTile LeaseBook::begin(Member member, UnitId id, Time now) {
    Unit& unit = m_units.at(id);
    if (unit.copies++ == 0 && !unit.is_check)
        m_leased_pixels += count_pixels(unit.band);
    m_leases[member].push_back({id, now, Time::max()});
    return unit.band;
}

void LeaseBook::forget_done() {
    if (m_pending_again == 0)
        return;
    std::erase_if(m_pending, [&](const Pending& p) {
        if (p.unit == 0)
            return false;
        const auto found = m_units.find(p.unit);
        if (found != m_units.end() && !found->second.done)
            return false;
        if (found != m_units.end() && found->second.copies == 0)
            m_units.erase(found);
        return true;
    });
    m_pending_again = static_cast<std::size_t>(std::count_if(
        m_pending.begin(), m_pending.end(), [](const Pending& p) { return p.unit != 0; }));
}

std::optional<tiles::RenderTile> LeaseBook::lease(Member member, std::size_t pixels, Time now) {
    forget_done();
    for (auto it = m_pending.begin(); it != m_pending.end(); ++it) {
        if (it->unit != 0) {
            const UnitId id = it->unit;
            const auto found = m_units.find(id);
            if (found == m_units.end() || found->second.done)
                continue;  // it was answered in the meantime: forget_done()
            const auto& own = m_leases[member];
            if (std::any_of(own.begin(), own.end(), [&](const Lease& l) { return l.unit == id; }))
                continue;
            found->second.is_pending = false;
            m_pending.erase(it);
            return begin(member, id, now);
        }
        tiles::RenderTile band = it->band;
        band.y1 = end_row(band, pixels);
        m_pending_pixels -= count_pixels(it->band);
        if (band.y1 < it->band.y1) {
            it->band.y0 = band.y1;
            m_pending_pixels += count_pixels(it->band);
        } else {
            m_pending.erase(it);
        }
        const UnitId id = m_next_unit++;
        m_units[id].band = band;
        return begin(member, id, now);
    }
    return std::nullopt;
}

tiles::RenderTile LeaseBook::lease_again(Member member, const tiles::RenderTile& of, Time now) {
    const auto found = std::find_if(m_units.begin(), m_units.end(), [&](const auto& u) {
        return !u.second.done && !u.second.is_check && u.second.copies > 0 && u.second.band == of;
    });
    return begin(member, found->first, now);
}

std::optional<tiles::RenderTile> LeaseBook::lease_check(Member member, Time now) {
    if (m_checks.empty())
        return std::nullopt;
    const UnitId id = m_checks.front();
    m_checks.pop_front();
    return begin(member, id, now);
}

void LeaseBook::set_deadline(Member member, const tiles::RenderTile& band, Time deadline) {
    for (Lease& lease : m_leases[member])
        if (m_units.at(lease.unit).band == band)
            lease.deadline = deadline;
}

// Of two leases of the same band, returns the one that is still needed: the other was withdrawn,
// and may never be answered.
std::vector<LeaseBook::Lease>::iterator LeaseBook::find_lease(std::vector<Lease>& leases,
                                                              const tiles::RenderTile& band) {
    const auto first = std::find_if(leases.begin(), leases.end(), [&](const Lease& l) {
        return m_units.at(l.unit).band == band;
    });
    const auto open = std::find_if(first, leases.end(), [&](const Lease& l) {
        return m_units.at(l.unit).band == band && !m_units.at(l.unit).done;
    });
    return open != leases.end() ? open : first;
}

void LeaseBook::end_lease(Member member, std::size_t place) {
    auto& own = m_leases[member];
    const UnitId id = own[place].unit;
    own.erase(own.begin() + static_cast<std::ptrdiff_t>(place));
    Unit& unit = m_units.at(id);
    --unit.copies;
    if (unit.copies == 0 && unit.done && !unit.is_pending)
        m_units.erase(id);
}

std::optional<tiles::TileResult> LeaseBook::add_part(Member member, tiles::TileResult&& result) {
    Slot& slot = m_slots.at(result.tile.index);
    const int first = result.tile.y0;
    slot.rows_left -= count_rows(result.tile);
    slot.parts[first] = {member, std::move(result)};
    if (slot.rows_left > 0)
        return std::nullopt;
    tiles::TileResult whole;
    if (slot.parts.size() == 1) {
        whole = std::move(slot.parts.begin()->second.result);
    } else {
        for (auto& [row, part] : slot.parts) {
            auto& r = part.result;
            std::move(r.samples.begin(), r.samples.end(), std::back_inserter(whole.samples));
            std::move(r.layers.begin(), r.layers.end(), std::back_inserter(whole.layers));
            std::move(r.bands.begin(), r.bands.end(), std::back_inserter(whole.bands));
            whole.counts.add(r.counts);
            whole.holes.merge(r.holes);
        }
    }
    slot.by.clear();
    for (const auto& [row, part] : slot.parts)
        if (std::find(slot.by.begin(), slot.by.end(), part.by) == slot.by.end())
            slot.by.push_back(part.by);
    slot.parts.clear();
    whole.tile = slot.tile;
    --m_unfinished;
    return whole;
}

LeaseBook::Taken LeaseBook::take(Member member, tiles::TileResult&& result) {
    Taken out;
    out.pixels = count_pixels(result.tile);
    const auto own = m_leases.find(member);
    if (own == m_leases.end())
        return out;
    const auto lease = find_lease(own->second, result.tile);
    if (lease == own->second.end())
        return out;
    const UnitId id = lease->unit;
    Unit& unit = m_units.at(id);
    if (unit.is_check) {
        // Settled before: its member was expelled for another reason.
        if (unit.done)
            out.answer = Answer::kLate;
        else if (tiles::hash_of_pixels(result) == unit.hash)
            out.answer = Answer::kChecked;
        else
            out.answer =
                is_comparable(unit.holes, result.holes) ? Answer::kFalse : Answer::kUndecided;
        out.other = unit.by;
        if (!std::exchange(unit.done, true))
            --m_open_checks;
        end_lease(member, static_cast<std::size_t>(lease - own->second.begin()));
        return out;
    }
    if (unit.done) {
        out.hash = tiles::hash_of_pixels(result);
        out.answer = unit.revoked || out.hash == unit.hash ? Answer::kLate : Answer::kUnequal;
        out.holes = std::move(result.holes);
        out.other = unit.by;
        out.other_hash = unit.hash;
        out.other_holes = unit.holes;
        end_lease(member, static_cast<std::size_t>(lease - own->second.begin()));
        return out;
    }
    out.answer = Answer::kFirst;
    unit.done = true;
    unit.by = member;
    unit.hash = tiles::hash_of_pixels(result);
    unit.holes = result.holes;
    m_leased_pixels -= out.pixels;
    if (unit.copies > 1)
        for (const auto& [other, leases] : m_leases)
            if (other != member && std::any_of(leases.begin(), leases.end(),
                                               [&](const Lease& l) { return l.unit == id; }))
                out.withdraw.push_back(other);
    end_lease(member, static_cast<std::size_t>(lease - own->second.begin()));
    out.whole = add_part(member, std::move(result));
    return out;
}

void LeaseBook::check(Member member, const tiles::RenderTile& band, std::uint64_t hash,
                      Holes holes) {
    const UnitId id = m_next_unit++;
    Unit& unit = m_units[id];
    unit.band = band;
    unit.is_check = true;
    unit.by = member;
    unit.hash = hash;
    unit.holes = std::move(holes);
    m_checks.push_back(id);
    ++m_open_checks;
}

void LeaseBook::put_back(UnitId id) {
    Unit& unit = m_units.at(id);
    if (unit.is_check) {
        if (!unit.done)
            m_checks.push_front(id);
        return;
    }
    if (unit.copies > 0)
        return;  // another member leases it
    if (!unit.done) {
        m_leased_pixels -= count_pixels(unit.band);
        m_pending_pixels += count_pixels(unit.band);
        // The next lease may cut it; if it is pending already, it is from now on a band like any
        // other.
        std::erase_if(m_pending, [&](const Pending& p) { return p.unit == id; });
        m_pending.push_front({unit.band, 0});
    }
    m_units.erase(id);
}

std::size_t LeaseBook::give_back(Member member) {
    const auto own = m_leases.find(member);
    if (own == m_leases.end())
        return 0;
    const std::vector<Lease> leases = std::move(own->second);
    m_leases.erase(own);
    std::size_t open = 0;
    for (const Lease& lease : leases) {
        Unit& unit = m_units.at(lease.unit);
        open += !unit.done ? 1u : 0u;
        --unit.copies;
        put_back(lease.unit);
    }
    return open;
}

void LeaseBook::give_back(Member member, const tiles::RenderTile& band) {
    auto& own = m_leases[member];
    const auto lease = find_lease(own, band);
    if (lease == own.end())
        return;
    const UnitId id = lease->unit;
    own.erase(lease);
    --m_units.at(id).copies;
    put_back(id);
}

std::vector<LeaseBook::Member> LeaseBook::expire(Time now) {
    std::vector<Member> late;
    for (auto& [member, leases] : m_leases)
        for (Lease& lease : leases) {
            if (lease.deadline > now)
                continue;
            lease.deadline = Time::max();
            Unit& unit = m_units.at(lease.unit);
            if (unit.done || unit.is_check)
                continue;
            if (late.empty() || late.back() != member)
                late.push_back(member);
            if (std::exchange(unit.is_pending, true))
                continue;
            m_pending.push_front({unit.band, lease.unit});
            ++m_pending_again;
        }
    return late;
}

std::vector<std::uint32_t> LeaseBook::revoke(Member member) {
    give_back(member);
    std::vector<std::uint32_t> whole_ones;
    for (auto& [index, slot] : m_slots) {
        const bool whole = slot.rows_left == 0;
        if (whole && std::find(slot.by.begin(), slot.by.end(), member) != slot.by.end()) {
            slot.rows_left = count_rows(slot.tile);
            slot.by.clear();
            m_pending.push_front({slot.tile, 0});
            m_pending_pixels += count_pixels(slot.tile);
            ++m_unfinished;
            whole_ones.push_back(index);
            continue;
        }
        for (auto it = slot.parts.begin(); it != slot.parts.end();) {
            if (it->second.by != member) {
                ++it;
                continue;
            }
            const tiles::RenderTile band = it->second.result.tile;
            slot.rows_left += count_rows(band);
            m_pending.push_front({band, 0});
            m_pending_pixels += count_pixels(band);
            it = slot.parts.erase(it);
        }
    }
    // This settles its other checks.
    for (auto it = m_units.begin(); it != m_units.end();) {
        Unit& unit = it->second;
        if (!unit.is_check && unit.done && unit.by == member)
            unit.revoked = true;
        if (unit.is_check && unit.by == member && !unit.done) {
            unit.done = true;
            --m_open_checks;
            std::erase(m_checks, it->first);
            if (unit.copies == 0) {
                it = m_units.erase(it);
                continue;
            }
        }
        ++it;
    }
    return whole_ones;
}

std::vector<LeaseBook::Open> LeaseBook::open_leases() const {
    std::vector<Open> out;
    for (const auto& [member, leases] : m_leases)
        for (const Lease& lease : leases) {
            const Unit& unit = m_units.at(lease.unit);
            if (!unit.done && !unit.is_check)
                out.push_back({member, unit.band, count_pixels(unit.band), lease.given,
                               unit.copies == 1 && !unit.is_pending});
        }
    return out;
}

LeaseBook::Load LeaseBook::measure_load(Member member) const {
    Load out;
    const auto own = m_leases.find(member);
    if (own == m_leases.end())
        return out;
    for (const Lease& lease : own->second) {
        const Unit& unit = m_units.at(lease.unit);
        if (unit.done)
            continue;
        ++out.leases;
        out.pixels += count_pixels(unit.band);
    }
    return out;
}

bool LeaseBook::has(Member member, const tiles::RenderTile& band) const {
    const auto own = m_leases.find(member);
    return own != m_leases.end() &&
           std::any_of(own->second.begin(), own->second.end(),
                       [&](const Lease& l) { return m_units.at(l.unit).band == band; });
}

}  // namespace terravox::processors
