#include "voxelserver/serve/http/token_tries.hpp"

#include <algorithm>

#include "voxelserver/serve/sockets/socket.hpp"

namespace terravox::http {
namespace {

std::string neighbourhood_of_host(const std::string& address) {
    const bool is_ipv6 = address.find(':') != std::string::npos;
    return sockets::neighbourhood_of((is_ipv6 ? "[" + address + "]" : address) + ":0");
}

}  // namespace

TokenTries::Client& TokenTries::client(const std::string& address, Time now) {
    const std::string name = neighbourhood_of_host(address);
    if (m_clients.size() >= kMaxKept && !m_clients.contains(name))
        m_clients.erase(std::min_element(
            m_clients.begin(), m_clients.end(),
            [](const auto& a, const auto& b) { return a.second.seen < b.second.seen; }));
    return m_clients.try_emplace(name, Client{now, now, std::nullopt}).first->second;
}

bool TokenTries::count(const std::string& address, bool is_right, Time now) {
    const std::lock_guard lock(m_mutex);
    Client& one = client(address, now);
    const bool is_trusted = one.right && now - *one.right < kTrusted;
    if (!is_trusted && one.all_free + kPause > now + kMax * kPause)
        return false;
    one.seen = now;
    if (is_right)
        one.right = now;
    else  // no more than kMax are owed, however many a trusted address has made
        one.all_free = std::min(std::max(one.all_free, now) + kPause, now + kMax * kPause);
    return true;
}

}  // namespace terravox::http
