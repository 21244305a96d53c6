#include "voxelserver/serve/host/send_reply.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <ctime>

#include "common/util/log.hpp"

namespace terravox::http {
namespace {

constexpr std::size_t kAtOnce_bytes = std::size_t{128} << 10;  // of a body

// No thread_local in this file has a destructor: to register one, a thread's first reply would wait
// for the dynamic loader's lock, which is held for long while the worlds module is loaded in the
// background. Objects to be destroyed with a thread belong to CivetWeb's thread pointer.

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

/// Writes the head of a reply whose body is chunked, ends with the connection, or has a length.
void write_head(std::string& out, const Response& r, bool chunked, bool keep_alive) {
    out.assign("HTTP/1.1 ").append(std::to_string(r.status)).append(" ");
    out.append(reason_phrase(r.status)).append("\r\nDate: ").append(http_date()).append("\r\n");
    out.append(r.head);
    if (chunked)
        out.append("Transfer-Encoding: chunked\r\n");
    else if (!r.stream && r.status != 204 && r.status != 304)
        out.append("Content-Length: ").append(std::to_string(r.body_bytes())).append("\r\n");
    // No page of another origin may embed a reply; SharedOrigins decides which may read one.
    out.append("X-Content-Type-Options: nosniff\r\nCross-Origin-Resource-Policy: same-origin\r\n");
    out.append(keep_alive ? "Connection: keep-alive\r\n\r\n" : "Connection: close\r\n\r\n");
}

// One call for head and body: each call is a packet and wakes the client. The rest of a large body
// is sent separately after its first part.
bool send_bytes(const Write& write, std::string& buffer, std::string_view body) {
    buffer.append(body.substr(0, kAtOnce_bytes));
    return write(buffer) && (body.size() <= kAtOnce_bytes || write(body.substr(kAtOnce_bytes)));
}

bool send_file(const Write& write, std::string& buffer, const FilePart& file,
               std::uint64_t& bytes) {
    bool alive = write(buffer);
    while (alive && bytes < file.bytes) {
        buffer.resize(std::min<std::uint64_t>(kAtOnce_bytes, file.bytes - bytes));
        const ssize_t got = ::pread(*file.descriptor, buffer.data(), buffer.size(),
                                    static_cast<off_t>(file.offset + bytes));
        alive = got > 0 && write({buffer.data(), static_cast<std::size_t>(got)});
        bytes += alive ? static_cast<std::uint64_t>(got) : 0;
    }
    return alive;
}

bool send_chunk(const Write& write, std::string_view part) {
    std::array<char, 24> size{};
    const int length = std::snprintf(size.data(), size.size(), "%zx\r\n", part.size());
    return write({size.data(), static_cast<std::size_t>(length)}) &&
           (part.empty() || write(part)) && write("\r\n");
}

bool send_stream(const Write& write, const std::string& head, const Response& r, bool chunked,
                 std::uint64_t& bytes) {
    bool alive = write(head);
    try {
        if (alive)
            r.stream([&](std::string_view part) {
                if (part.empty())
                    return alive;
                alive = alive && (chunked ? send_chunk(write, part) : write(part));
                bytes += alive ? part.size() : 0;
                return alive;
            });
    } catch (const std::exception& e) {
        util::log_error("send a stream: {}", e.what());
        return false;
    }
    return alive && (!chunked || send_chunk(write, ""));
}

}  // namespace

bool wants_keep_alive(const Request& request) {
    const std::string connection = request.header("Connection");
    if (connection.empty())
        return request.version == "1.1";
    for (std::string_view list = connection; !list.empty();)
        if (same_word(take_element(list), "keep-alive"))
            return true;
    return false;
}

SentReply send_reply(const Write& write, std::string& buffer, const Response& reply, bool head_only,
                     bool keep_alive, bool http_1_0) {
    const bool chunked = reply.stream && !http_1_0;
    SentReply out;
    out.keep_alive = keep_alive && (chunked || !reply.stream);
    write_head(buffer, reply, chunked, out.keep_alive);
    bool sent = false;
    if (head_only) {
        sent = write(buffer);
    } else if (reply.stream) {
        sent = send_stream(write, buffer, reply, chunked, out.body_bytes);
    } else if (reply.file) {
        sent = send_file(write, buffer, *reply.file, out.body_bytes);
    } else {
        out.body_bytes = reply.bytes().size();
        sent = send_bytes(write, buffer, reply.bytes());
    }
    out.keep_alive = out.keep_alive && sent;
    return out;
}

}  // namespace terravox::http
