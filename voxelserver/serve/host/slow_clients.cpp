#include "voxelserver/serve/host/slow_clients.hpp"

#include <dirent.h>
#include <fcntl.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <map>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "common/util/error.hpp"
#include "common/util/log.hpp"
#include "voxelserver/serve/sockets/socket.hpp"

namespace terravox::http {
namespace {

using sockets::Endpoint;

constexpr std::chrono::milliseconds kPause{100};  // between two looks
constexpr std::chrono::seconds kLogInterval{60};  // minimum interval between messages

/// A connection of a client to this host.
struct Connection {
    int fd = -1;
    std::string name;     ///< address and port of the client
    std::string address;  ///< Endpoint::neighbourhood()
    bool unread = false;  ///< whether bytes of the client have not been read yet
};

std::optional<Endpoint> find_end(int fd, int (*name_of_end)(int, sockaddr*, socklen_t*)) noexcept {
    Endpoint out;
    out.size_bytes = sizeof out.storage;
    if (name_of_end(fd, reinterpret_cast<sockaddr*>(&out.storage), &out.size_bytes) != 0)
        return std::nullopt;
    if (out.storage.ss_family != AF_INET && out.storage.ss_family != AF_INET6)
        return std::nullopt;
    return out;
}

/// @return the client's endpoint, if the descriptor is a connection to `port`
std::optional<Endpoint> find_client(int fd, int port) noexcept {
    const auto here = find_end(fd, ::getsockname);
    if (!here || here->port() != port)
        return std::nullopt;
    return find_end(fd, ::getpeername);  // a listening socket has none
}

struct CloseFolder {
    void operator()(DIR* folder) const noexcept { ::closedir(folder); }
};

std::vector<Connection> list_connections(int port) {
    const std::unique_ptr<DIR, CloseFolder> folder(::opendir("/proc/self/fd"));
    if (!folder)
        throw util::Error(std::string("list the descriptors of this process in /proc/self/fd: ") +
                          std::strerror(errno));
    std::vector<Connection> out;
    while (const dirent* entry = ::readdir(folder.get())) {
        const std::string_view name(entry->d_name);
        int fd = -1;
        if (std::from_chars(name.data(), name.data() + name.size(), fd).ec != std::errc())
            continue;  // . and ..
        const auto client = find_client(fd, port);
        if (!client)
            continue;
        int bytes = 0;
        const bool unread = ::ioctl(fd, FIONREAD, &bytes) == 0 && bytes > 0;
        out.push_back({fd, client->text(), client->neighbourhood(), unread});
    }
    return out;
}

/// Meanwhile the descriptor may belong to another connection, or a file: only the intended
/// connection is shut down, or none.
bool shut_down(const Connection& connection, int port) noexcept {
    const sockets::Socket same(::fcntl(connection.fd, F_DUPFD_CLOEXEC, 0));
    if (!same)
        return false;
    const auto client = find_client(same.fd(), port);
    return client && client->text() == connection.name && ::shutdown(same.fd(), SHUT_RDWR) == 0;
}

// In the format of Endpoint::text(): without the zone of a link-local address, which CivetWeb adds.
std::string to_name(const std::string& given, int port) {
    return sockets::Address{given.substr(0, given.find('%')), static_cast<std::uint16_t>(port)}
        .text();
}

}  // namespace

SlowClients::SlowClients(int max_connections, std::chrono::milliseconds timeout)
    : m_max_connections(max_connections), m_timeout(timeout) {}

SlowClients::~SlowClients() {
    {
        const std::lock_guard lock(m_mutex);
        m_stopping = true;
    }
    m_changed.notify_all();
    if (m_thread.joinable())
        m_thread.join();
}

void SlowClients::watch(int port) {
    m_port = port;
    m_thread = std::thread([this] { run(); });
}

SlowClients::Answering::Answering(SlowClients& clients, const std::string& address, int port)
    : m_clients(clients), m_name(to_name(address, port)) {
    const std::lock_guard lock(m_clients.m_mutex);
    ++m_clients.m_connections[m_name].answering;
}

SlowClients::Answering::~Answering() {
    const std::lock_guard lock(m_clients.m_mutex);
    Facts& facts = m_clients.m_connections.find(m_name)->second;  // kept while it is answered
    --facts.answering;
    facts.waited = false;
    facts.since = Clock::now();
}

void SlowClients::run() noexcept {
    bool failed = false;
    for (;;) {
        {
            std::unique_lock lock(m_mutex);
            if (m_changed.wait_for(lock, kPause, [&] { return m_stopping; }))
                return;
        }
        try {
            close_waiting();
            failed = false;
        } catch (const std::exception& e) {
            if (!failed)
                util::log_warn(
                    "watch for slow clients: {}; until that works they can take all threads",
                    e.what());
            failed = true;
        }
    }
}

void SlowClients::close_waiting() {
    const std::vector<Connection> open = list_connections(m_port);
    // By address, with the times since which they wait.
    std::map<std::string, std::vector<std::pair<Clock::time_point, const Connection*>>> waiting;
    {
        const std::lock_guard lock(m_mutex);
        const auto now = Clock::now();
        for (const Connection& one : open) {
            Facts& facts = m_connections[one.name];
            facts.seen = true;
            // Between reading the end of a request and marking it as being answered, a connection
            // seems to wait: it counts only when it did so at the look before as well.
            const bool waits = facts.answering == 0 && !one.unread;
            if (std::exchange(facts.waited, waits) && waits && now - facts.since >= m_timeout)
                waiting[one.address].emplace_back(facts.since, &one);
        }
        std::erase_if(m_connections, [](const auto& one) {
            return !one.second.seen && one.second.answering == 0;
        });
        for (auto& [name, facts] : m_connections)
            facts.seen = false;
    }
    for (auto& [address, connections] : waiting)
        std::sort(connections.rbegin(), connections.rend());  // the longest-waiting last
    for (std::size_t left = open.size();
         left > static_cast<std::size_t>(m_max_connections) && !waiting.empty(); --left) {
        const auto worst = std::max_element(
            waiting.begin(), waiting.end(),
            [](const auto& a, const auto& b) { return a.second.size() < b.second.size(); });
        if (shut_down(*worst->second.back().second, m_port))
            log_closed(worst->first);
        worst->second.pop_back();
        if (worst->second.empty())
            waiting.erase(worst);
    }
}

void SlowClients::log_closed(const std::string& address) {
    const std::uint64_t before = m_closed++;
    const auto now = Clock::now();
    if (now < m_log_again_at)
        return;
    m_log_again_at = now + kLogInterval;
    util::log_warn(
        "more than {} connections are open: those whose clients do not finish their requests are "
        "closed, such as one of {}; {} before",
        m_max_connections, address, before);
}

}  // namespace terravox::http
