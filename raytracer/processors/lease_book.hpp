#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "raytracer/tiles/tile.hpp"

namespace terravox::processors {

/// Which rows of which tiles are to do, who has them, and what has come back. It knows no processor
/// and reads no clock. Not thread-safe.
///
/// A *band* is some rows of a tile of the plan; a whole tile is a band, too. A member of the pool
/// leases bands, and a tile is whole when all its bands have come. A band may be leased to several
/// members; the first answer counts, later ones must be equal. Of members that are not to be
/// trusted some bands are made again by one who is (checks).
class LeaseBook {
public:
    using Time = std::chrono::steady_clock::time_point;
    using Member = std::uint32_t;
    using Holes = std::set<voxel::BoxKey>;

    /// A tile to do. Tiles of one pass have different indices; the next pass may begin when all are
    /// handed out.
    void add(const tiles::RenderTile& tile);

    /// Rows that nobody has, of one tile, about so many pixels, at least eight rows. @return
    /// nullopt: there are none for this member
    [[nodiscard]] std::optional<tiles::RenderTile> lease(Member member, std::size_t pixels,
                                                         Time now);
    /// The same band once more for another member. @param of one of open_leases()
    [[nodiscard]] tiles::RenderTile lease_again(Member member, const tiles::RenderTile& of,
                                                Time now);
    /// A band that somebody else has made, to compare. For members to be trusted.
    [[nodiscard]] std::optional<tiles::RenderTile> lease_check(Member member, Time now);
    /// From when on the band goes to others as well. None is set at first.
    void set_deadline(Member member, const tiles::RenderTile& band, Time deadline);

    enum class Answer : std::uint8_t {
        kFirst,      ///< counts
        kLate,       ///< equal to one that came before, or not to be compared
        kUnequal,    ///< of the two members that answered, one is wrong
        kUnasked,    ///< the member had no such lease
        kChecked,    ///< equal to what was to be checked
        kFalse,      ///< unequal to what was to be checked
        kUndecided,  ///< unequal, but the check met a hole that the band's member did not: that one
                     ///< may have had the box
    };
    struct Taken {
        Answer answer = Answer::kUnasked;
        std::optional<tiles::TileResult> whole;  ///< a tile that is whole by this
        std::size_t pixels = 0;                  ///< of the band
        Member other = 0;  ///< kUnequal: who answered first; of checks: whose band it was
        std::uint64_t hash = 0, other_hash = 0;  ///< kUnequal: of this answer, and of the other's
        Holes holes, other_holes;                ///< kUnequal: of this answer, and of the other's
        std::vector<Member> withdraw;            ///< kFirst: who else works on it
    };
    Taken take(Member member, tiles::TileResult&& result);
    /// A band that has come, or some rows of it, shall be made again by somebody else.
    /// @param hash hash_of_pixels of those rows
    /// @param holes that the member met in the band
    void check(Member member, const tiles::RenderTile& band, std::uint64_t hash, Holes holes);
    /// Whether an answer is wrong where it differs from one to be trusted. Holes are the
    /// coordinator's, and once a box is one it stays so: who is to be trusted meets every hole that
    /// the member met before it, so equal holes make equal pixels. The member may have had a box
    /// earlier, or from a server of its own, that is a hole by now.
    [[nodiscard]] static bool is_comparable(const Holes& of_member, const Holes& trusted);

    /// What the member has goes to others. @return bands
    std::size_t give_back(Member member);
    void give_back(Member member, const tiles::RenderTile& band);
    /// Bands whose deadline has passed go to others, too. @return the members who are late, each
    /// once
    std::vector<Member> expire(Time now);
    /// All that came from the member is to do again. @return indices of the tiles that were whole
    [[nodiscard]] std::vector<std::uint32_t> revoke(Member member);
    /// Whether it has made any of an earlier pass, which is beyond mending.
    [[nodiscard]] bool spoiled_earlier(Member member) const { return m_earlier.contains(member); }

    struct Open {
        Member member;
        tiles::RenderTile band;
        std::size_t pixels;
        Time given;
        bool alone;  ///< nobody else has it
    };
    /// Leases of bands that have not come, checks left out.
    [[nodiscard]] std::vector<Open> open_leases() const;
    struct Load {
        std::size_t leases = 0, pixels = 0;
    };
    [[nodiscard]] Load load_of(Member member) const;
    [[nodiscard]] bool has(Member member, const tiles::RenderTile& band) const;
    [[nodiscard]] std::size_t pending_pixels() const noexcept { return m_pending_pixels; }
    [[nodiscard]] std::size_t leased_pixels() const noexcept {
        return m_leased_pixels;
    }  ///< that have not come
    [[nodiscard]] std::size_t open_checks() const noexcept { return m_open_checks; }
    [[nodiscard]] bool checks_wait() const noexcept { return !m_checks.empty(); }
    /// Tiles that are not whole, for the first time or again.
    [[nodiscard]] std::size_t unfinished() const noexcept { return m_unfinished; }

    [[nodiscard]] static std::size_t pixels_of(const tiles::RenderTile& band) noexcept;
    static constexpr int kMinRows =
        8;  ///< of traced pixels in a band: two rows of blocks, which beams are made of

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
        std::vector<Member> by;     ///< who has made any of it, once it is whole
    };
    /// A band that is or was leased.
    struct Unit {
        tiles::RenderTile band;
        Holes holes;           ///< in the answer
        bool revoked = false;  ///< by who answered first: nothing is compared with it
        bool done = false, is_check = false,
             waits = false;  ///< waits: in m_pending, beside those who have it
        int copies = 0;
        Member by = 0;           ///< who answered first; of a check: whose it is
        std::uint64_t hash = 0;  ///< of the answer
    };
    struct Lease {
        UnitId unit;
        Time given, deadline;
    };
    struct Pending {
        tiles::RenderTile band;
        UnitId unit = 0;  ///< not 0: somebody has had it for too long; it may not be cut
    };
    void forget_done();
    void put_back(UnitId id);
    [[nodiscard]] tiles::RenderTile begin(Member member, UnitId id, Time now);
    [[nodiscard]] std::vector<Lease>::iterator lease_of(std::vector<Lease>& leases,
                                                        const tiles::RenderTile& band);
    void end_lease(Member member, std::size_t place);
    void new_pass();
    std::optional<tiles::TileResult> add_part(Member member, tiles::TileResult&& result);

    std::unordered_map<std::uint32_t, Slot> m_slots;  ///< by the tile's index
    std::deque<Pending> m_pending;
    std::deque<UnitId> m_checks;
    std::unordered_map<UnitId, Unit> m_units;
    std::unordered_map<Member, std::vector<Lease>> m_leases;
    std::unordered_set<Member> m_earlier;  ///< who has made any of an earlier pass
    UnitId m_next_unit = 1;
    std::size_t m_pending_again = 0;  ///< of m_pending, those that somebody has
    std::size_t m_pending_pixels = 0, m_leased_pixels = 0, m_open_checks = 0, m_unfinished = 0;
};

}  // namespace terravox::processors
