// Requests to the voxel server, as its router gets them: request line, headers, body.
#include <algorithm>
#include <optional>
#include <string_view>
#include <utility>

#include "tests/fuzz/fuzz.hpp"
#include "tests/voxelserver/serve/http/fake_world.hpp"
#include "voxelserver/serve/http/router.hpp"

namespace terravox::fuzz {
namespace {

/// @return the text up to `end`, which is taken away with it; all of it where there is none
std::string_view take_until(std::string_view& text, std::string_view end) {
    const std::size_t at = text.find(end);
    const std::string_view out = text.substr(0, at);
    text.remove_prefix(at == std::string_view::npos ? text.size() : at + end.size());
    return out;
}

http::Request parse(std::string_view text) {
    http::Request out;
    out.method = take_until(text, " ");
    std::string_view target = take_until(text, "\n");
    out.path = take_until(target, "?");
    out.query = target;
    while (!text.empty()) {
        std::string_view line = take_until(text, "\n");
        if (line.empty())
            break;
        http::Header header;
        header.name = take_until(line, ": ");
        header.value = line;
        out.headers.push_back(header);
    }
    out.body = text;
    return out;
}

struct Server {
    test::FakeWorld world;
    util::StageTimes times;
    boxes::BoxCache boxes{world, times, {.ahead = false}};
    http::Router router{http::Service{world, times, boxes}};
};

/// Lines that end where lines end, and no other control characters: nothing that a client said
/// splits a reply.
bool is_head(std::string_view head) {
    while (!head.empty()) {
        if (head.find("\r\n") == std::string_view::npos)
            return false;
        const std::string_view line = take_until(head, "\r\n");
        if (line.find(": ") == std::string_view::npos)
            return false;
        if (std::any_of(line.begin(), line.end(),
                        [](char c) { return static_cast<unsigned char>(c) < 32 || c == 127; }))
            return false;
    }
    return true;
}

}  // namespace

void run(Input input) {
    static Server server;
    const std::string text = as_text(input);
    const http::Request request = parse(text);
    // As the server does: a body is read only where the head alone is no reason to refuse it.
    std::optional<http::Response> refused = server.router.refusal(request);
    const http::Response reply = refused ? std::move(*refused) : server.router.handle(request);
    expect(reply.status >= 200 && reply.status < 600, "a reply has a status");
    expect(reply.status != 500, "no request is an error of the server's own");
    expect(is_head(reply.head), "a reply's head is made of lines");
    if (!reply.stream)
        return;
    std::size_t sent = 0;
    reply.stream([&](std::string_view part) {
        sent += part.size();
        return sent < (std::size_t{1} << 20);
    });
}

}  // namespace terravox::fuzz
