#include "common/util/printable.hpp"

#include <array>
#include <cstdint>
#include <cstdio>

namespace terravox::util {
namespace {

struct Character {
    std::size_t bytes = 0;  ///< 0: not valid UTF-8
    std::uint32_t code = 0;
};

Character first_of(std::string_view text) noexcept {
    const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
    const unsigned char lead = byte(0);
    if (lead < 0x80)
        return {1, lead};
    const std::size_t bytes = lead >= 0xf0 ? 4 : lead >= 0xe0 ? 3 : 2;
    if (lead < 0xc2 || lead > 0xf4 || text.size() < bytes)
        return {};
    std::uint32_t code = lead & (0xffU >> (bytes + 1));
    for (std::size_t i = 1; i < bytes; ++i) {
        if ((byte(i) & 0xc0) != 0x80)
            return {};
        code = code << 6 | (byte(i) & 0x3fU);
    }
    constexpr std::array<std::uint32_t, 5> kMin = {0, 0, 0x80, 0x800, 0x10000};
    const bool is_surrogate = code >= 0xd800 && code < 0xe000;
    if (code < kMin[bytes] || code > 0x10ffff || is_surrogate)
        return {};
    return {bytes, code};
}

bool is_harmful(std::uint32_t code) noexcept {
    if (code < 0x20 || (code >= 0x7f && code < 0xa0))
        return true;  // C0, DEL, C1
    if (code == 0x2028 || code == 0x2029)
        return true;  // line and paragraph separators
    if (code == 0x061c || code == 0x200e || code == 0x200f)
        return true;  // bidirectional marks
    return (code >= 0x202a && code <= 0x202e) ||
           (code >= 0x2066 && code <= 0x2069);  // embeddings, overrides, isolates
}

std::string escape_of(std::uint32_t code) {
    if (code == '\n')
        return "\\n";
    if (code == '\r')
        return "\\r";
    if (code == '\t')
        return "\\t";
    std::array<char, 16> out{};
    std::snprintf(out.data(), out.size(), code <= 0x7f ? "\\x%02x" : "\\u%04x",
                  static_cast<unsigned>(code));
    return out.data();
}

}  // namespace

std::string printable(std::string_view text) {
    std::string out;
    out.reserve(text.size());
    while (!text.empty()) {
        const Character c = first_of(text);
        if (c.bytes == 0) {
            std::array<char, 8> byte{};
            std::snprintf(byte.data(), byte.size(), "\\x%02x",
                          static_cast<unsigned>(static_cast<unsigned char>(text.front())));
            out += byte.data();
            text.remove_prefix(1);
            continue;
        }
        if (is_harmful(c.code))
            out += escape_of(c.code);
        else
            out += text.substr(0, c.bytes);
        text.remove_prefix(c.bytes);
    }
    return out;
}

}  // namespace terravox::util
