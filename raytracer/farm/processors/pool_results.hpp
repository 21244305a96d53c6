#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <unordered_set>
#include <utility>
#include <vector>

#include "raytracer/core/tiles/tile.hpp"
#include "raytracer/farm/processors/pool_members.hpp"

namespace terravox::processors {

/// Finished tiles for the caller, which takes each tile of a pass once. A tile whose pixels turn
/// out to be wrong is invalidated: if the caller has taken it already, it is returned again
/// (TileResult::again). Not thread-safe.
class ResultQueue {
public:
    /// Announces a tile that the caller will take. The first tile of another pass begins that pass.
    void expect(const tiles::RenderTile& tile);
    /// @return whether expect(tile) would begin another pass
    [[nodiscard]] bool begins_pass(const tiles::RenderTile& tile) const noexcept {
        return m_pass != to_pass(tile);
    }

    void push(tiles::TileResult&& result);
    /// Whether there is a tile to take. The last tile is kept back until no tile can be invalidated
    /// any more, as it ends the picture.
    /// @param checks_open whether some checks are not answered yet
    [[nodiscard]] bool can_take(bool checks_open) const noexcept;
    /// @pre can_take()
    [[nodiscard]] tiles::TileResult take();

    /// To be called when a finished tile is computed again.
    void invalidate(std::uint32_t index);
    /// @return indices of tiles that had been taken when they were invalidated, since the last call
    [[nodiscard]] std::vector<std::uint32_t> take_invalidated() {
        return std::exchange(m_invalidated, {});
    }

    /// @return whether so many tiles wait for the caller that members must wait, to bound the
    /// memory
    [[nodiscard]] bool is_full() const noexcept { return m_ready.size() > kMaxReady; }
    /// @return tiles that are still to be taken, for the first time or again
    [[nodiscard]] std::size_t tiles_left() const noexcept { return m_first_left + m_again_left; }
    /// @return tiles that are still to be taken again
    [[nodiscard]] std::size_t again_left() const noexcept { return m_again_left; }
    /// @return whether samples of this pass are merged with those of earlier ones
    [[nodiscard]] bool is_merged() const noexcept { return m_pass.first_sample != 0; }

private:
    static constexpr std::size_t kMaxReady = 1024;
    struct Pass {
        std::uint32_t pass = 0;
        std::uint32_t first_sample = 0;
        friend bool operator==(const Pass&, const Pass&) = default;
    };
    [[nodiscard]] static Pass to_pass(const tiles::RenderTile& tile) noexcept {
        return {tile.pass, tile.first_sample};
    }

    std::deque<tiles::TileResult> m_ready;
    std::vector<std::uint32_t> m_invalidated;
    std::unordered_set<std::uint32_t> m_taken;  ///< tiles of this pass
    Pass m_pass;
    std::size_t m_first_left = 0;
    std::size_t m_again_left = 0;
};

/// Records which members failed at which bands. When enough different members fail at the same
/// rows, the picture is at fault rather than they. Bands are cut anew when they are reassigned, so
/// rows are compared, not bands. Not thread-safe.
class FailureLog {
public:
    /// When this many different members fail at the same rows, the rows are considered untraceable.
    static constexpr std::size_t kMaxMembers = 3;

    /// @param identity of the member (MemberSpec::identity); one that fails repeatedly counts once
    /// @return number of different members that have failed at any of these rows so far
    std::size_t add(const tiles::RenderTile& band, const std::string& identity);

private:
    struct Failure {
        tiles::RenderTile band;
        std::string identity;
    };
    std::vector<Failure> m_failures;  ///< all different
};

/// Decides which bands of untrusted members are recomputed, and which of their rows.
/// The choice is random, so that a member cannot predict it. Not thread-safe.
class CheckPolicy {
public:
    /// @param check_every  one of this many bands of a member is checked, and always its first; 0
    /// or less: none
    /// @param seed         seed of the random choice
    CheckPolicy(int check_every, std::uint64_t seed) noexcept
        : m_check_every(check_every), m_random(seed | 1) {}

    /// @return whether the band that the member has just answered is checked; this ends a request
    /// for a check
    [[nodiscard]] bool is_due(PoolMember& member) noexcept;
    /// @return the rows of a band to recompute: the smallest number that keeps blocks of pixels
    /// whole, at a random position
    [[nodiscard]] tiles::RenderTile choose_rows(tiles::RenderTile band) noexcept;

private:
    [[nodiscard]] std::uint64_t next_random() noexcept;

    int m_check_every;
    std::uint64_t m_random;
};

/// Enters answers into the lease book, requests checks of some of them, and detects members that
/// send wrong pixels. It has no thread and reads no clock. Not thread-safe.
class ResultValidator {
public:
    using Time = LeaseBook::Time;

    /// The consequences of an answer.
    struct Verdict {
        LeaseBook::Answer answer = LeaseBook::Answer::kUnrequested;
        std::optional<tiles::TileResult> whole;  ///< a tile that this answer completes
        /// Processors of other members that compute the same band.
        std::vector<std::shared_ptr<TileProcessor>> withdraw_from;
        MemberId untrusted = 0;  ///< a member that has sent wrong pixels; 0: none
        std::string reason;      ///< why it is not trusted
    };

    /// @param book, members  outlive the validator
    ResultValidator(LeaseBook& book, MemberRegistry& members, CheckPolicy policy) noexcept
        : m_book(book), m_members(members), m_policy(policy) {}

    /// @param id, member  of the registry
    [[nodiscard]] Verdict validate(MemberId id, PoolMember& member, tiles::TileResult&& result,
                                   Time now);

private:
    /// Rows to recompute, and the hash and holes that the member has sent for them.
    struct Check {
        tiles::RenderTile rows;
        std::uint64_t hash = 0;
        LeaseBook::Holes holes;
    };
    [[nodiscard]] std::optional<Check> choose_check(PoolMember& member,
                                                    const tiles::TileResult& result);
    [[nodiscard]] MemberId settle_unequal(MemberId id, const PoolMember& member,
                                          const tiles::RenderTile& band, LeaseBook::Taken&& taken);

    LeaseBook& m_book;
    MemberRegistry& m_members;
    CheckPolicy m_policy;
};

}  // namespace terravox::processors
