#include "raytracer/farm/coordinator/dialled_addresses.hpp"

namespace terravox::farm {

std::optional<std::uint64_t> DialledAddresses::add(const std::string& address) {
    if (!m_turns.try_emplace(address, m_next_turn).second)
        return std::nullopt;
    return m_next_turn++;
}

void DialledAddresses::remove(const std::string& address) {
    m_turns.erase(address);
}

void DialledAddresses::remove(const std::string& address, std::uint64_t turn) {
    if (has(address, turn))
        m_turns.erase(address);
}

bool DialledAddresses::has(const std::string& address, std::uint64_t turn) const {
    const auto found = m_turns.find(address);
    return found != m_turns.end() && found->second == turn;
}

std::vector<std::string> DialledAddresses::list() const {
    std::vector<std::string> out;
    for (const auto& [address, turn] : m_turns)
        out.push_back(address);
    return out;
}

}  // namespace terravox::farm
