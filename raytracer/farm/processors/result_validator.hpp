#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "raytracer/farm/processors/check_policy.hpp"
#include "raytracer/farm/processors/member_registry.hpp"

namespace terravox::processors {

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
