#include "raytracer/farm/processors/member_registry.hpp"

#include <algorithm>
#include <utility>

namespace terravox::processors {

MemberId MemberRegistry::add(MemberSpec spec, bool checks_only, Time now) {
    const MemberId id = m_next_id++;
    m_members.try_emplace(id, std::move(spec), checks_only, now);
    return id;
}

std::optional<PoolMember> MemberRegistry::remove(MemberId id) {
    const auto found = m_members.find(id);
    if (found == m_members.end())
        return std::nullopt;
    std::optional<PoolMember> out(std::move(found->second));
    m_members.erase(found);
    return out;
}

PoolMember* MemberRegistry::find(MemberId id) noexcept {
    const auto found = m_members.find(id);
    return found == m_members.end() ? nullptr : &found->second;
}

const PoolMember* MemberRegistry::find(MemberId id) const noexcept {
    const auto found = m_members.find(id);
    return found == m_members.end() ? nullptr : &found->second;
}

bool MemberRegistry::has_workers() const noexcept {
    return std::any_of(m_members.begin(), m_members.end(),
                       [](const auto& m) { return !m.second.checks_only(); });
}

bool MemberRegistry::takes_work(const PoolMember& member) const noexcept {
    return (!member.checks_only() || m_stands_in) && member.is_available();
}

bool MemberRegistry::traces_here() const noexcept {
    return m_stands_in || std::any_of(m_members.begin(), m_members.end(), [this](const auto& m) {
               return m.second.spec().trusted && takes_work(m.second);
           });
}

double MemberRegistry::pixels_per_s() const noexcept {
    double sum = 0;
    for (const auto& [id, member] : m_members)
        if (takes_work(member))
            sum += member.pixels_per_s();
    return sum;
}

bool MemberRegistry::claim_checker() noexcept {
    const bool has_trusted = std::any_of(m_members.begin(), m_members.end(),
                                         [](const auto& m) { return m.second.spec().trusted; });
    return !has_trusted && !std::exchange(m_checker_claimed, true);
}

}  // namespace terravox::processors
