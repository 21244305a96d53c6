#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace terravox::test {

/// What the server does with one request.
struct Deed {
    int status = 200;
    std::string type = "application/json";
    std::string body = {};
    std::string headers = {};           ///< further ones, each ending in "\r\n"
    std::chrono::milliseconds late{0};  ///< before the first byte
    std::chrono::milliseconds drip{0};  ///< after each byte of the body
    bool silent = false;                ///< takes the request and says nothing
    std::size_t lost = 0;  ///< bytes of the body that never come: the connection ends before them
    std::size_t rest = 0;  ///< bytes of the body that come only after before_rest
    std::function<void()> before_rest = {};
};

/// A web server on a free local port that does to each request what the test sets: late, silent,
/// dripping, damaged. A thread for each connection.
class BadServer {
public:
    /// What to do with the n-th request (from 0) for a path. Called from several threads, one at a
    /// time.
    using Script = std::function<Deed(const std::string& path, int n)>;
    /// The body of a request; of one for a range of bytes "FIRST-LAST".
    using BodyScript = std::function<Deed(const std::string& path, int n, const std::string& body)>;

    explicit BadServer(Script script)
        : BadServer([script = std::move(script)](const std::string& path, int n,
                                                 const std::string&) { return script(path, n); }) {}
    explicit BadServer(BodyScript script)
        : m_script(std::move(script)), m_listener(::socket(AF_INET, SOCK_STREAM, 0)) {
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        socklen_t size = sizeof address;
        auto* generic = reinterpret_cast<sockaddr*>(&address);
        if (m_listener < 0 || ::bind(m_listener, generic, size) != 0 ||
            ::listen(m_listener, 64) != 0 || ::getsockname(m_listener, generic, &size) != 0)
            throw std::runtime_error("start the test's server: no local port");
        m_port = ntohs(address.sin_port);
        m_thread = std::thread([this] { listen(); });
    }
    ~BadServer() {
        m_stop = true;
        m_thread.join();
        for (std::thread& t : m_connections)
            t.join();
        ::close(m_listener);
    }
    BadServer(const BadServer&) = delete;
    BadServer& operator=(const BadServer&) = delete;

    [[nodiscard]] std::string url() const { return "http://127.0.0.1:" + std::to_string(m_port); }
    [[nodiscard]] int requests(const std::string& path) const {
        const std::lock_guard lock(m_mutex);
        const auto found = m_requests.find(path);
        return found == m_requests.end() ? 0 : found->second;
    }
    /// Of replies to requests for this path, heads as well.
    [[nodiscard]] std::size_t sent_bytes(const std::string& path) const {
        const std::lock_guard lock(m_mutex);
        const auto found = m_sent_bytes.find(path);
        return found == m_sent_bytes.end() ? 0 : found->second;
    }
    /// Request lines and headers, as they came.
    [[nodiscard]] std::vector<std::string> heads() const {
        const std::lock_guard lock(m_mutex);
        return m_heads;
    }

private:
    /// @return whether there is something to read; false when the server ends
    bool readable(int socket) const {
        while (!m_stop) {
            pollfd one{socket, POLLIN, 0};
            if (::poll(&one, 1, 20) > 0)
                return true;
        }
        return false;
    }
    /// @return false when the server ends, or the client has gone
    bool rest(int socket, std::chrono::milliseconds time) const {
        const auto end = std::chrono::steady_clock::now() + time;
        while (!m_stop && std::chrono::steady_clock::now() < end) {
            pollfd one{socket, POLLRDHUP, 0};
            const auto left = std::chrono::ceil<std::chrono::milliseconds>(
                end - std::chrono::steady_clock::now());
            if (::poll(&one, 1, static_cast<int>(std::clamp<std::int64_t>(left.count(), 0, 20))) >
                0)
                return false;
        }
        return !m_stop;
    }
    void listen() {
        while (readable(m_listener)) {
            const int socket = ::accept(m_listener, nullptr, nullptr);
            if (socket < 0)
                continue;
            m_connections.emplace_back([this, socket] {
                serve(socket);
                ::close(socket);
            });
        }
    }
    bool send_bytes(int socket, const std::string& path, const std::string& bytes) {
        const ssize_t sent = ::send(socket, bytes.data(), bytes.size(), MSG_NOSIGNAL);
        const std::lock_guard lock(m_mutex);
        if (sent > 0)
            m_sent_bytes[path] += static_cast<std::size_t>(sent);
        return sent == static_cast<ssize_t>(bytes.size());
    }

    void serve(int socket) {
        std::string request;
        const auto read_until = [&](const std::function<bool()>& enough) {
            while (!enough()) {
                char bytes[4096];
                if (!readable(socket))
                    return false;
                const auto count = ::recv(socket, bytes, sizeof bytes, 0);
                if (count <= 0)
                    return false;
                request.append(bytes, static_cast<std::size_t>(count));
            }
            return true;
        };
        if (!read_until([&] { return request.find("\r\n\r\n") != std::string::npos; }))
            return;
        const std::size_t body_at = request.find("\r\n\r\n") + 4;
        const std::size_t length_at = request.find("Content-Length: ");
        const std::size_t length =
            length_at < body_at ? std::stoul(request.substr(length_at + 16)) : 0;
        if (!read_until([&] { return request.size() >= body_at + length; }))
            return;
        const auto begin = request.find(' ') + 1;
        const std::string path = request.substr(begin, request.find(' ', begin) - begin);
        const Deed deed = [&] {
            const std::lock_guard lock(m_mutex);
            m_heads.push_back(request.substr(0, body_at));
            const std::size_t range_at = request.find("Range: bytes=");
            const bool ranged = range_at < body_at;
            return m_script(
                path, m_requests[path]++,
                ranged ? request.substr(range_at + 13, request.find('\r', range_at) - range_at - 13)
                       : request.substr(body_at));
        }();
        const auto send = [&](int to, const std::string& bytes) {
            return send_bytes(to, path, bytes);
        };
        if (deed.silent) {
            (void)rest(socket, std::chrono::hours(1));
            return;
        }
        if (!rest(socket, deed.late))
            return;
        std::string head = "HTTP/1.1 " + std::to_string(deed.status) +
                           " Whatever\r\nConnection: close\r\n" + deed.headers;
        if (deed.status != 204)
            head += "Content-Type: " + deed.type +
                    "\r\nContent-Length: " + std::to_string(deed.body.size()) + "\r\n";
        std::string body = deed.body.substr(0, deed.body.size() - deed.lost);
        if (!send(socket, head + "\r\n"))
            return;
        if (deed.rest > 0) {
            if (!send(socket, body.substr(0, body.size() - deed.rest)))
                return;
            deed.before_rest();
            body.erase(0, body.size() - deed.rest);
        }
        if (deed.drip.count() == 0) {
            (void)send(socket, body);
            return;
        }
        for (const char byte : body)
            if (!send(socket, std::string(1, byte)) || !rest(socket, deed.drip))
                return;
    }

    BodyScript m_script;
    int m_listener;
    int m_port = 0;
    std::atomic<bool> m_stop{false};
    mutable std::mutex m_mutex;  ///< guards m_requests, m_sent_bytes, m_heads and the script
    std::map<std::string, int> m_requests;
    std::map<std::string, std::size_t> m_sent_bytes;
    std::vector<std::string> m_heads;
    std::vector<std::thread> m_connections;  ///< touched by m_thread, then by the destructor
    std::thread m_thread;
};

}  // namespace terravox::test
