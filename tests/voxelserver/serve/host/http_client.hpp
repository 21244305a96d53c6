#pragma once

#include <arpa/inet.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstdint>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

namespace terravox::test {

struct HttpReply {
    int status = 0;
    std::map<std::string, std::string> headers;  ///< names in lower case
    std::string body;
};

/// One connection to 127.0.0.1, byte for byte: it sends what no proper client would.
class HttpClient {
public:
    explicit HttpClient(int port) : m_socket(::socket(AF_INET, SOCK_STREAM, 0)) {
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_port = htons(static_cast<std::uint16_t>(port));
        address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        const timeval timeout{300, 0};  // what ends a test that hangs
        setsockopt(m_socket, SOL_SOCKET, SO_RCVTIMEO, &timeout, sizeof timeout);
        m_connected =
            connect(m_socket, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
    }
    ~HttpClient() { close(m_socket); }
    HttpClient(const HttpClient&) = delete;
    HttpClient& operator=(const HttpClient&) = delete;

    [[nodiscard]] bool connected() const noexcept { return m_connected; }

    void send(const std::string& bytes) {
        std::size_t sent = 0;
        while (sent < bytes.size()) {
            const auto n = ::send(m_socket, bytes.data() + sent, bytes.size() - sent, MSG_NOSIGNAL);
            if (n <= 0)
                return;  // the server has closed: its reply, if any, can still be read
            sent += static_cast<std::size_t>(n);
        }
    }
    void end_of_request() { shutdown(m_socket, SHUT_WR); }

    HttpReply get(const std::string& path, const std::string& more_headers = "",
                  const std::string& method = "GET") {
        send(method + " " + path + " HTTP/1.1\r\nHost: localhost\r\n" + more_headers + "\r\n");
        auto reply = read_reply(method == "HEAD");
        if (!reply)
            throw std::runtime_error("no reply to " + path);
        return *reply;
    }

    /// @return nullopt when the connection ended before a whole reply
    std::optional<HttpReply> read_reply(bool head_only = false) {
        std::size_t end = 0;
        while ((end = m_buffer.find("\r\n\r\n")) == std::string::npos)
            if (!receive())
                return std::nullopt;
        HttpReply reply = parse_head(m_buffer.substr(0, end));
        m_buffer.erase(0, end + 4);
        const auto length = reply.headers.find("content-length");
        const std::size_t bytes =
            head_only || length == reply.headers.end() ? 0 : std::stoul(length->second);
        while (m_buffer.size() < bytes)
            if (!receive())
                return std::nullopt;
        reply.body = m_buffer.substr(0, bytes);
        m_buffer.erase(0, bytes);
        return reply;
    }

    /// Reads until the server closes. @return what came since the last reply
    std::string read_to_end() {
        while (receive()) {
        }
        return std::exchange(m_buffer, {});
    }

    /// Waits until the server closes; what comes until then is dropped. @return false when it did
    /// not within 30 s
    [[nodiscard]] bool wait_for_end() {
        char bytes[4096];
        for (;;) {
            const auto n = recv(m_socket, bytes, sizeof bytes, 0);
            if (n == 0 || (n < 0 && errno == ECONNRESET))
                return true;
            if (n < 0 && errno != EINTR)
                return false;
        }
    }

private:
    bool receive() {
        char bytes[4096];
        const auto n = recv(m_socket, bytes, sizeof bytes, 0);
        if (n <= 0)
            return false;
        m_buffer.append(bytes, static_cast<std::size_t>(n));
        return true;
    }

    static HttpReply parse_head(const std::string& head) {
        HttpReply reply;
        if (head.rfind("HTTP/1.1 ", 0) != 0)
            throw std::runtime_error("not a status line: " + head.substr(0, 80));
        reply.status = std::stoi(head.substr(9, 3));
        std::size_t at = head.find("\r\n");
        while (at != std::string::npos) {
            const std::size_t next = head.find("\r\n", at + 2);
            const std::string line =
                head.substr(at + 2, next == std::string::npos ? next : next - at - 2);
            std::string name = line.substr(0, line.find(':'));
            std::transform(name.begin(), name.end(), name.begin(),
                           [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
            reply.headers[name] = line.substr(line.find(':') + 2);
            at = next;
        }
        return reply;
    }

    int m_socket;
    bool m_connected = false;
    std::string m_buffer;
};

}  // namespace terravox::test
