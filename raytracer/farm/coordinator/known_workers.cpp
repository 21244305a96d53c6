#include "raytracer/farm/coordinator/known_workers.hpp"

namespace terravox::farm {
namespace {

std::string find_host(const std::string& peer) {
    return peer.substr(0, peer.rfind(':'));
}

std::string name_at(const std::string& name, const std::string& host) {
    return name + " of " + host;
}

}  // namespace

void BanList::ban(const Worker& worker) {
    if (!worker.dialled.empty()) {
        m_banned.insert(worker.dialled);
        return;
    }
    const std::string host = find_host(worker.peer);
    if (m_banned.insert(name_at(worker.name, host)).second)
        ++m_number_of_host[host];
}

bool BanList::has(const Worker& worker) const {
    if (!worker.dialled.empty())
        return m_banned.contains(worker.dialled);
    const auto host = m_number_of_host.find(find_host(worker.peer));
    return host != m_number_of_host.end() &&
           (host->second >= kMaxOfHost || m_banned.contains(name_at(worker.name, host->first)));
}

std::optional<std::uint64_t> DialledAddresses::add(const std::string& address) {
    if (!m_turns.try_emplace(address, m_next_turn).second)
        return std::nullopt;
    return m_next_turn++;
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
