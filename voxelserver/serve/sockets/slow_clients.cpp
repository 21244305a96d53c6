#include "voxelserver/serve/sockets/slow_clients.hpp"

#include <dirent.h>
#include <fcntl.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <condition_variable>
#include <cstring>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "common/util/error.hpp"
#include "common/util/log.hpp"
#include "voxelserver/serve/sockets/socket.hpp"

namespace terravox::sockets {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kPause{100};  // between two scans
constexpr std::chrono::seconds kLogInterval{60};  // minimum interval between messages
// Between the moment at which a thread has read the end of a request and the moment at which it
// registers it, a connection seems to wait for its client: it is considered waiting only if it does
// so in two consecutive scans.
constexpr int kMinScans = 2;

/// A connection of a client to this server.
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

std::vector<Connection> connections_to(int port) {
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
    const Socket same(::fcntl(connection.fd, F_DUPFD_CLOEXEC, 0));
    if (!same)
        return false;
    const auto client = find_client(same.fd(), port);
    return client && client->text() == connection.name && ::shutdown(same.fd(), SHUT_RDWR) == 0;
}

// In the format of Endpoint::text(): without the zone of a link-local address, which CivetWeb adds.
std::string to_name(const std::string& given, int port) {
    const std::string address = given.substr(0, given.find('%'));
    const bool brackets = address.find(':') != std::string::npos;
    return (brackets ? "[" + address + "]:" : address + ":") + std::to_string(port);
}

}  // namespace

struct SlowClients::Known {
    struct Facts {
        /// Time of the last reply, or when it was first seen.
        Clock::time_point since = Clock::now();
        /// Number of requests; 0 or 1, except for a moment when a port is reused.
        int answering = 0;
        int waiting_scans = 0;   ///< number of consecutive scans in which it waited for its client
        std::uint64_t seen = 0;  ///< number of the last scan that found it
    };
    std::mutex mutex;
    std::condition_variable changed;
    bool stopping = false;
    std::unordered_map<std::string, Facts> connections;
    // Used only by the watching thread.
    std::uint64_t scans = 0;
    Clock::time_point log_again_at = Clock::time_point::min();
};

SlowClients::SlowClients(const Limits& limits)
    : m_limits(limits), m_known(std::make_unique<Known>()) {}

SlowClients::~SlowClients() {
    {
        const std::lock_guard lock(m_known->mutex);
        m_known->stopping = true;
    }
    m_known->changed.notify_all();
    if (m_thread.joinable())
        m_thread.join();
}

void SlowClients::watch(int port) {
    m_port = port;
    m_thread = std::thread([this] { run(); });
}

SlowClients::Answering::Answering(SlowClients& clients, const std::string& address, int port)
    : m_clients(clients), m_name(to_name(address, port)) {
    m_clients.begin(m_name);
}
SlowClients::Answering::~Answering() {
    m_clients.end(m_name);
}

void SlowClients::begin(const std::string& name) {
    const std::lock_guard lock(m_known->mutex);
    ++m_known->connections[name].answering;
}

void SlowClients::end(const std::string& name) noexcept {
    const std::lock_guard lock(m_known->mutex);
    const auto found = m_known->connections.find(name);
    if (found == m_known->connections.end())
        return;
    --found->second.answering;
    found->second.waiting_scans = 0;
    found->second.since = Clock::now();
}

void SlowClients::run() noexcept {
    bool failed = false;
    for (;;) {
        {
            std::unique_lock lock(m_known->mutex);
            if (m_known->changed.wait_for(lock, kPause, [&] { return m_known->stopping; }))
                return;
        }
        try {
            scan();
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

void SlowClients::scan() {
    const std::vector<Connection> open = connections_to(m_port);
    std::map<std::string, std::vector<std::pair<Clock::time_point, const Connection*>>>
        waiting;  // by address
    {
        const std::lock_guard lock(m_known->mutex);
        ++m_known->scans;
        const auto now = Clock::now();
        for (const Connection& one : open) {
            Known::Facts& facts = m_known->connections[one.name];
            facts.seen = m_known->scans;
            facts.waiting_scans = facts.answering > 0 || one.unread ? 0 : facts.waiting_scans + 1;
            if (facts.waiting_scans >= kMinScans && now - facts.since >= m_limits.timeout)
                waiting[one.address].emplace_back(facts.since, &one);
        }
        std::erase_if(m_known->connections, [&](const auto& one) {
            return one.second.answering == 0 && one.second.seen != m_known->scans;
        });
    }
    for (auto& [address, connections] : waiting)
        std::sort(connections.rbegin(), connections.rend());  // the longest-waiting last
    for (std::size_t left = open.size();
         left > static_cast<std::size_t>(m_limits.connections) && !waiting.empty(); --left) {
        const auto worst = std::max_element(
            waiting.begin(), waiting.end(),
            [](const auto& a, const auto& b) { return a.second.size() < b.second.size(); });
        if (shut_down(*worst->second.back().second, m_port)) {
            ++m_closed;
            log_closed(worst->first);
        }
        worst->second.pop_back();
        if (worst->second.empty())
            waiting.erase(worst);
    }
}

void SlowClients::log_closed(const std::string& address) {
    const auto now = Clock::now();
    if (now < m_known->log_again_at)
        return;
    m_known->log_again_at = now + kLogInterval;
    util::log_warn(
        "more than {} connections are open: those whose clients do not finish their requests are "
        "closed, such as one of {}; {} before",
        m_limits.connections, address, m_closed - 1);
}

}  // namespace terravox::sockets
