#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "raytracer/core/tiles/tile.hpp"

namespace terravox::processors {

/// Records which rows of which tiles are to be traced, which members lease them, and which results
/// have arrived. It knows no processor and reads no clock. Not thread-safe.
///
/// A *band* is some rows of a tile of the plan; a whole tile is a band, too. A member of the pool
/// leases bands, and a tile is whole when all its bands have arrived. A band may be leased to
/// several members; the first answer counts, later ones must be equal. Some bands of untrusted
/// members are recomputed by a trusted one (checks).
class LeaseBook {
public:
    using Time = std::chrono::steady_clock::time_point;
    using Member = std::uint32_t;
    using Holes = std::set<voxel::BoxKey>;

    /// Adds a tile. Tiles of one pass have different indices; the next pass may begin when all
    /// tiles are whole.
    void add(const tiles::RenderTile& tile);

    /// Leases rows of one tile that no member has leased: about this many pixels, at least eight
    /// rows.
    /// @return nullopt: there are none for this member
    [[nodiscard]] std::optional<tiles::RenderTile> lease(Member member, std::size_t pixels,
                                                         Time now);
    /// Leases the same band to another member, too.
    /// @param of one of open_leases()
    [[nodiscard]] tiles::RenderTile lease_again(Member member, const tiles::RenderTile& of,
                                                Time now);
    /// Leases a band of another member, to compare the results. For trusted members.
    [[nodiscard]] std::optional<tiles::RenderTile> lease_check(Member member, Time now);
    /// Sets the time from which the band may be leased to others as well. There is none at first.
    void set_deadline(Member member, const tiles::RenderTile& band, Time deadline);

    enum class Answer : std::uint8_t {
        kFirst,        ///< the first answer: it counts
        kLate,         ///< equal to an earlier one, or not comparable
        kUnequal,      ///< one of the two members that answered is wrong
        kUnrequested,  ///< the member has no such lease
        kChecked,      ///< equal to the checked result
        kFalse,        ///< unequal to the checked result
        kUndecided,  ///< unequal, but the check met a hole that the band's member did not: that one
                     ///< may have had the box
    };
    struct Taken {
        Answer answer = Answer::kUnrequested;
        std::optional<tiles::TileResult> whole;  ///< a tile that this answer completes
        std::size_t pixels = 0;                  ///< size of the band
        /// kUnequal: the member that answered first; for checks: the band's member.
        Member other = 0;
        std::uint64_t hash = 0;        ///< kUnequal: hash of this answer
        std::uint64_t other_hash = 0;  ///< kUnequal: hash of the other's answer
        Holes holes;                   ///< kUnequal: holes of this answer
        Holes other_holes;             ///< kUnequal: holes of the other's answer
        std::vector<Member> withdraw;  ///< kFirst: other members that work on the band
    };
    Taken take(Member member, tiles::TileResult&& result);
    /// Requests that another member recomputes a finished band, or some rows of it.
    /// @param hash hash_of_pixels of those rows
    /// @param holes that the member met in the band
    void check(Member member, const tiles::RenderTile& band, std::uint64_t hash, Holes holes);
    /// Whether an answer that differs from a trusted one is wrong. Holes are the coordinator's, and
    /// a hole stays a hole: a trusted member meets every hole that the member met before it, so
    /// equal holes make equal pixels. The member may have received a box earlier, or from a server
    /// of its own, that is a hole by now.
    [[nodiscard]] static bool is_comparable(const Holes& of_member, const Holes& trusted) {
        return std::includes(of_member.begin(), of_member.end(), trusted.begin(), trusted.end());
    }

    /// Returns all leases of the member, so that they are leased to others.
    /// @return number of bands
    std::size_t give_back(Member member);
    void give_back(Member member, const tiles::RenderTile& band);
    /// Makes bands whose deadline has passed available to others, too.
    /// @return the members that are late, each once
    std::vector<Member> expire(Time now);
    /// Discards all results of the member, so that they are computed again.
    /// @return indices of the tiles that were whole
    [[nodiscard]] std::vector<std::uint32_t> revoke(Member member);
    /// Whether the member has computed any of an earlier pass, which cannot be recomputed any more.
    [[nodiscard]] bool contributed_earlier(Member member) const {
        return m_earlier.contains(member);
    }

    struct Open {
        Member member;
        tiles::RenderTile band;
        std::size_t pixels;
        Time given;
        bool alone;  ///< no other member leases it
    };
    /// Leases of bands that have not been answered, without checks.
    [[nodiscard]] std::vector<Open> open_leases() const;
    struct Load {
        std::size_t leases = 0;
        std::size_t pixels = 0;
    };
    [[nodiscard]] Load measure_load(Member member) const;
    [[nodiscard]] bool has(Member member, const tiles::RenderTile& band) const;
    [[nodiscard]] std::size_t pending_pixels() const noexcept { return m_pending_pixels; }
    /// Pixels that are leased and not answered.
    [[nodiscard]] std::size_t leased_pixels() const noexcept { return m_leased_pixels; }
    [[nodiscard]] std::size_t open_checks() const noexcept { return m_open_checks; }
    [[nodiscard]] bool checks_wait() const noexcept { return !m_checks.empty(); }
    /// Tiles that are not whole, for the first time or again.
    [[nodiscard]] std::size_t unfinished() const noexcept { return m_unfinished; }

    [[nodiscard]] static std::size_t count_pixels(const tiles::RenderTile& band) noexcept;
    /// Minimum number of rows of traced pixels in a band: two rows of blocks, which beams consist
    /// of.
    static constexpr int kMinRows = 8;

private:
    using UnitId = std::uint64_t;
    struct Part {
        Member by;
        tiles::TileResult result;
    };
    struct Slot {
        tiles::RenderTile tile;
        int rows_left = 0;
        std::map<int, Part> parts;  ///< by the first row
        std::vector<Member> by;     ///< members that have computed any of it, once it is whole
    };
    /// A band that is or was leased.
    struct Unit {
        tiles::RenderTile band;
        Holes holes;           ///< holes in the answer
        bool revoked = false;  ///< the member that answered first was expelled: nothing is compared
                               ///< with its answer
        bool done = false;
        bool is_check = false;
        bool is_pending = false;  ///< in m_pending, although members lease it
        int copies = 0;
        Member by = 0;           ///< the member that answered first; for a check: the band's member
        std::uint64_t hash = 0;  ///< hash of the answer
    };
    struct Lease {
        UnitId unit;
        Time given;
        Time deadline;
    };
    struct Pending {
        tiles::RenderTile band;
        UnitId unit = 0;  ///< not 0: its lease is overdue; it may not be cut
    };
    void forget_done();
    void put_back(UnitId id);
    [[nodiscard]] tiles::RenderTile begin(Member member, UnitId id, Time now);
    [[nodiscard]] std::vector<Lease>::iterator find_lease(std::vector<Lease>& leases,
                                                          const tiles::RenderTile& band);
    void end_lease(Member member, std::size_t place);
    void new_pass();
    std::optional<tiles::TileResult> add_part(Member member, tiles::TileResult&& result);

    std::unordered_map<std::uint32_t, Slot> m_slots;  ///< by the tile's index
    std::deque<Pending> m_pending;
    std::deque<UnitId> m_checks;
    std::unordered_map<UnitId, Unit> m_units;
    std::unordered_map<Member, std::vector<Lease>> m_leases;
    std::unordered_set<Member> m_earlier;  ///< members that have computed any of an earlier pass
    UnitId m_next_unit = 1;
    std::size_t m_pending_again = 0;  ///< number of bands in m_pending that are leased
    std::size_t m_pending_pixels = 0;
    std::size_t m_leased_pixels = 0;
    std::size_t m_open_checks = 0;
    std::size_t m_unfinished = 0;
};

}  // namespace terravox::processors
