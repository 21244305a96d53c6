#pragma once

#include <map>
#include <optional>

#include "raytracer/farm/processors/pool_member.hpp"

namespace terravox::processors {

/// The members of a pool, and which kind of work each of them takes. It has no thread and reads no
/// clock. Not thread-safe.
///
/// The *checker* is a member that the pool makes itself if no other one is trusted: it checks the
/// bands of others. When it stands in for members that have failed, it traces as well.
class MemberRegistry {
public:
    using Time = LeaseBook::Time;

    /// @param checks_only whether it is the checker
    MemberId add(MemberSpec spec, bool checks_only, Time now);
    /// @return the member that was removed; nullopt for an unknown id
    std::optional<PoolMember> remove(MemberId id);
    /// @return nullptr for an unknown id
    [[nodiscard]] PoolMember* find(MemberId id) noexcept;
    [[nodiscard]] const PoolMember* find(MemberId id) const noexcept;
    /// All members, in the order in which they joined.
    [[nodiscard]] std::map<MemberId, PoolMember>& all() noexcept { return m_members; }
    [[nodiscard]] const std::map<MemberId, PoolMember>& all() const noexcept { return m_members; }

    /// @return whether there is any member apart from the checker
    [[nodiscard]] bool has_workers() const noexcept;
    /// @return whether the member takes bands, apart from checks
    [[nodiscard]] bool takes_work(const PoolMember& member) const noexcept;
    /// @return whether a member of this process traces bands that others cannot
    [[nodiscard]] bool traces_here() const noexcept;
    /// @return the total speed of the members that take work
    [[nodiscard]] double pixels_per_s() const noexcept;

    /// @return true, once, if no member is trusted: the caller must then make the checker
    [[nodiscard]] bool claim_checker() noexcept;
    /// From now on the checker traces bands, too.
    void stand_in() noexcept { m_stands_in = true; }
    [[nodiscard]] bool stands_in() const noexcept { return m_stands_in; }

private:
    std::map<MemberId, PoolMember> m_members;
    MemberId m_next_id = 1;
    bool m_checker_claimed = false;
    bool m_stands_in = false;
};

}  // namespace terravox::processors
