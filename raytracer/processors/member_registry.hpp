#pragma once

#include <map>
#include <optional>

#include "raytracer/processors/pool_member.hpp"

namespace terravox::processors {

/// The members of a pool, and which of them take part in what. It has no thread and reads no clock.
/// Not thread-safe.
///
/// The *checker* is a member that the pool makes itself, where no other one is trusted: it checks
/// the bands of others. Where it stands in for members that have failed, it traces as well.
class MemberRegistry {
public:
    using Time = LeaseBook::Time;

    /// @param checks_only  it is the checker
    MemberId add(MemberSpec spec, bool checks_only, Time now);
    /// @return the member that was removed; nullopt where there is none of this id
    std::optional<PoolMember> remove(MemberId id);
    /// @return nullptr where there is none of this id
    [[nodiscard]] PoolMember* find(MemberId id) noexcept;
    [[nodiscard]] const PoolMember* find(MemberId id) const noexcept;
    /// In the order in which they came.
    [[nodiscard]] std::map<MemberId, PoolMember>& all() noexcept { return m_members; }
    [[nodiscard]] const std::map<MemberId, PoolMember>& all() const noexcept { return m_members; }

    /// @return whether somebody is there apart from the checker
    [[nodiscard]] bool has_workers() const noexcept;
    /// @return whether the member takes bands, apart from checks
    [[nodiscard]] bool takes_work(const PoolMember& member) const noexcept;
    /// @return whether some of this process tries all that others cannot trace
    [[nodiscard]] bool traces_here() const noexcept;
    /// @return the speed of all that take work
    [[nodiscard]] double pixels_per_s() const noexcept;

    /// @return true, once, where no member is trusted: the caller then makes the checker
    [[nodiscard]] bool claim_checker() noexcept;
    /// From now on the checker traces whatever is to do.
    void stand_in() noexcept { m_stands_in = true; }
    [[nodiscard]] bool stands_in() const noexcept { return m_stands_in; }

private:
    std::map<MemberId, PoolMember> m_members;
    MemberId m_next_id = 1;
    bool m_checker_claimed = false;
    bool m_stands_in = false;
};

}  // namespace terravox::processors
