#include "raytracer/farm/coordinator/ban_list.hpp"

namespace terravox::farm {
namespace {

std::string host_of(const std::string& peer) {
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
    const std::string host = host_of(worker.peer);
    if (m_banned.insert(name_at(worker.name, host)).second)
        ++m_number_of_host[host];
}

bool BanList::has(const Worker& worker) const {
    if (!worker.dialled.empty())
        return m_banned.contains(worker.dialled);
    const auto host = m_number_of_host.find(host_of(worker.peer));
    return host != m_number_of_host.end() &&
           (host->second >= kMaxOfHost || m_banned.contains(name_at(worker.name, host->first)));
}

}  // namespace terravox::farm
