// The handshake of a farm, on both sides.
// The first byte says in how many bytes at a time the others come.
#include "raytracer/farm/net/handshake.hpp"

#include <algorithm>

#include "tests/fuzz/fuzz.hpp"

namespace terravox::fuzz {
namespace {

void listen(Input input, std::size_t at_once) {
    net::ListenerHandshake listener("a token");
    auto left = std::as_bytes(input);
    while (!left.empty() && listener.wanted() > 0) {
        const auto part = left.first(std::min({left.size(), at_once, listener.wanted()}));
        left = left.subspan(part.size());
        const auto step = listener.take(part);
        expect(step.outcome != net::ListenerHandshake::Outcome::kProven,
               "no random input proves a token");
        if (step.outcome != net::ListenerHandshake::Outcome::kMore)
            break;
    }
    (void)listener.answer(net::Verdict::kWrongToken);
}

void dial(Input input) {
    net::DiallerHandshake dialler("a token");
    (void)dialler.hello();
    const auto bytes = std::as_bytes(input);
    if (bytes.size() < net::kHello_bytes + net::kAnswer_bytes)
        return;
    (void)dialler.prove(bytes.first<net::kHello_bytes>());
    dialler.check(bytes.subspan<net::kHello_bytes, net::kAnswer_bytes>());
    expect(false, "no answer proves a token by chance");
}

}  // namespace

void run(Input input) {
    if (input.empty())
        return;
    listen(input.subspan(1), std::size_t{1} + input[0]);
    allow_errors([&] { dial(input.subspan(1)); });
}

}  // namespace terravox::fuzz
