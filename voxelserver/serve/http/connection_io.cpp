#include "voxelserver/serve/http/connection_io.hpp"

#include <civetweb.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <ctime>

#include "common/util/log.hpp"

namespace terravox::http {
namespace {

constexpr std::string_view kLastResortBody =
    "{\"type\":\"about:blank\",\"title\":\"Internal Server Error\",\"status\":500}\n";
constexpr std::string_view kLastResortHead =
    "HTTP/1.1 500 Internal Server Error\r\nContent-Type: "
    "application/problem+json\r\nContent-Length: 68\r\nConnection: close\r\n\r\n";
static_assert(kLastResortBody.size() == 68);

// No thread_local in this file has a destructor: to register one, a thread's first reply would wait
// for the dynamic loader's lock, which is held for long while the worlds module is loaded in the
// background. Objects to be destroyed with a thread belong to CivetWeb's thread pointer
// (the buffer for whole replies).

// Formatted once a second per thread, since it took a tenth of the time of a small reply.
std::string_view http_date() {
    thread_local std::time_t written = 0;
    thread_local std::array<char, 40> text{};
    thread_local std::size_t length = 0;
    if (const std::time_t now = std::time(nullptr); now != written) {
        std::tm utc{};
        gmtime_r(&now, &utc);
        length = std::strftime(text.data(), text.size(), "%a, %d %b %Y %H:%M:%S GMT", &utc);
        written = now;
    }
    return {text.data(), length};
}

enum class Length { kKnown, kChunked, kUntilClose };

void append_head(std::string& out, const Response& r, Length length, bool keep_alive) {
    out.append("HTTP/1.1 ")
        .append(std::to_string(r.status))
        .append(" ")
        .append(reason_phrase(r.status));
    out.append("\r\nDate: ").append(http_date()).append("\r\n").append(r.head);
    if (length == Length::kChunked)
        out.append("Transfer-Encoding: chunked\r\n");
    else if (length == Length::kKnown && r.status != 204 && r.status != 304)
        out.append("Content-Length: ").append(std::to_string(r.body_bytes())).append("\r\n");
    // No page of another origin may embed a reply; SharedOrigins decides which may read one.
    out.append("X-Content-Type-Options: nosniff\r\nCross-Origin-Resource-Policy: same-origin\r\n");
    out.append(keep_alive ? "Connection: keep-alive\r\n\r\n" : "Connection: close\r\n\r\n");
}

bool has_token(const std::string& list, std::string_view token) {
    std::size_t begin = 0;
    while (begin <= list.size()) {
        const std::size_t end = std::min(list.find(',', begin), list.size());
        std::string_view word(list.data() + begin, end - begin);
        while (!word.empty() && (word.front() == ' ' || word.front() == '\t'))
            word.remove_prefix(1);
        while (!word.empty() && (word.back() == ' ' || word.back() == '\t'))
            word.remove_suffix(1);
        if (same_word(word, token))
            return true;
        begin = end + 1;
    }
    return false;
}

bool write_all(mg_connection* connection, const char* data, std::size_t bytes) noexcept {
    return bytes == 0 || mg_write(connection, data, bytes) == static_cast<int>(bytes);
}

// One call for head and body: each call is a packet and wakes the client. The rest of a large body
// is sent separately after its first part.
bool send_whole(mg_connection* connection, const Response& r, bool keep_alive) {
    constexpr std::size_t kTogether = std::size_t{128} << 10;
    std::string& out = *static_cast<std::string*>(mg_get_thread_pointer(connection));
    out.clear();
    append_head(out, r, Length::kKnown, keep_alive);
    const std::string_view body = r.head_only ? std::string_view() : r.bytes();
    out.append(body.substr(0, kTogether));
    bool sent = write_all(connection, out.data(), out.size());
    if (sent && body.size() > kTogether)
        sent = write_all(connection, body.data() + kTogether, body.size() - kTogether);
    return sent;
}

// A file that cannot be read to its end ends the connection: the client sees that bytes are
// missing.
bool send_file(mg_connection* connection, const Response& r, bool keep_alive,
               std::uint64_t& bytes) {
    constexpr std::size_t kAtOnce = std::size_t{128} << 10;
    std::string& buffer = *static_cast<std::string*>(mg_get_thread_pointer(connection));
    buffer.clear();
    append_head(buffer, r, Length::kKnown, keep_alive);
    bool alive = write_all(connection, buffer.data(), buffer.size());
    bytes = 0;
    const std::uint64_t wanted = r.head_only ? 0 : r.file->bytes;
    while (alive && bytes < wanted) {
        buffer.resize(static_cast<std::size_t>(std::min<std::uint64_t>(kAtOnce, wanted - bytes)));
        const ssize_t got = ::pread(*r.file->descriptor, buffer.data(), buffer.size(),
                                    static_cast<off_t>(r.file->offset + bytes));
        alive = got > 0 && write_all(connection, buffer.data(), static_cast<std::size_t>(got));
        bytes += alive ? static_cast<std::uint64_t>(got) : 0;
    }
    return alive;
}

// HTTP/1.0 has no chunked encoding: there, closing the connection ends the body.
bool send_stream(mg_connection* connection, const Response& r, bool chunked, bool keep_alive,
                 std::uint64_t& bytes) {
    std::string head;
    append_head(head, r, chunked ? Length::kChunked : Length::kUntilClose, keep_alive);
    bool alive = write_all(connection, head.data(), head.size());
    if (r.head_only)
        return alive;
    // An error can no longer be reported to the client: the stream is cut off, and the client
    // detects that it is incomplete.
    const auto write = [&](std::string_view part) {
        if (part.empty())
            return alive;
        if (chunked)
            alive = alive &&
                    mg_send_chunk(connection, part.data(), static_cast<unsigned>(part.size())) > 0;
        else
            alive = alive && write_all(connection, part.data(), part.size());
        if (alive)
            bytes += part.size();
        return alive;
    };
    try {
        if (alive)
            r.stream(write);
    } catch (const std::exception& e) {
        util::log_error("send a stream: {}", e.what());
        alive = false;
    }
    if (alive && chunked)
        alive = mg_send_chunk(connection, "", 0) >= 0;
    return alive;
}

}  // namespace

Request make_request(const mg_request_info& info) {
    Request out;
    out.method = info.request_method;
    out.path = info.local_uri_raw;  // not decoded: no path of the interface needs escapes
    if (info.query_string != nullptr)
        out.query = info.query_string;
    out.client = info.remote_addr;
    out.headers.reserve(static_cast<std::size_t>(info.num_headers));
    for (int i = 0; i < info.num_headers; ++i)
        out.headers.push_back({info.http_headers[i].name, info.http_headers[i].value});
    return out;
}

bool wants_keep_alive(const Request& request, const char* http_version) {
    const std::string connection = request.header("Connection");
    if (!connection.empty())
        return has_token(connection, "keep-alive");
    return http_version != nullptr && std::strcmp(http_version, "1.1") == 0;
}

bool read_body(mg_connection* connection, std::uint64_t bytes, std::chrono::milliseconds timeout,
               std::string& body) {
    const auto give_up = std::chrono::steady_clock::now() + timeout;
    body.resize(bytes);
    std::size_t have = 0;
    while (have < bytes) {
        const int n = mg_read(connection, body.data() + have, bytes - have);
        if (n <= 0 || std::chrono::steady_clock::now() > give_up)
            return false;
        have += static_cast<std::size_t>(n);
    }
    return true;
}

std::uint64_t send_response(mg_connection* connection, const Response& r, bool keep_alive,
                            bool http_1_0) {
    if (r.stream && http_1_0)
        keep_alive = false;
    std::uint64_t bytes = r.head_only ? 0 : r.bytes().size();
    bool sent = false;
    if (r.stream)
        sent = send_stream(connection, r, !http_1_0, keep_alive, bytes);
    else if (r.file)
        sent = send_file(connection, r, keep_alive, bytes);
    else
        sent = send_whole(connection, r, keep_alive);
    // Closing also prevents CivetWeb from reading (and waiting for) a body of any length that the
    // client has announced.
    if (!sent || !keep_alive)
        mg_disable_connection_keep_alive(connection);
    return bytes;
}

void send_last_resort(mg_connection* connection) noexcept {
    if (write_all(connection, kLastResortHead.data(), kLastResortHead.size()))
        write_all(connection, kLastResortBody.data(), kLastResortBody.size());
    mg_disable_connection_keep_alive(connection);
}

}  // namespace terravox::http
