#include "common/util/utf8.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace terravox::util {

Character first_character(std::string_view text) noexcept {
    const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
    const unsigned char lead = byte(0);
    if (lead < 0x80)
        return {1, lead};
    const std::size_t bytes = lead >= 0xf0 ? 4 : lead >= 0xe0 ? 3 : 2;
    if (lead < 0xc2 || lead > 0xf4 || text.size() < bytes)
        return {};
    char32_t code = lead & (0xffU >> (bytes + 1));
    for (std::size_t i = 1; i < bytes; ++i) {
        if ((byte(i) & 0xc0) != 0x80)
            return {};
        code = code << 6 | (byte(i) & 0x3fU);
    }
    constexpr std::array<char32_t, 5> kMin = {0, 0, 0x80, 0x800, 0x10000};
    const bool is_surrogate = code >= 0xd800 && code < 0xe000;
    if (code < kMin[bytes] || code > 0x10ffff || is_surrogate)
        return {};
    return {bytes, code};
}

void append_utf8(std::string& out, char32_t code) {
    int rest = code < 0x80 ? 0 : code < 0x800 ? 1 : code < 0x10000 ? 2 : 3;
    constexpr std::array kHeads{0x00, 0xc0, 0xe0, 0xf0};
    out.push_back(static_cast<char>(kHeads[static_cast<std::size_t>(rest)] | code >> (6 * rest)));
    while (--rest >= 0)
        out.push_back(static_cast<char>(0x80 | (code >> (6 * rest) & 0x3f)));
}

std::vector<std::string> broken_lines(std::string_view text,
                                      const std::function<bool(const std::string&)>& fits) {
    std::vector<std::string> lines;
    std::string line;
    while (!text.empty()) {
        const std::size_t bytes = std::max<std::size_t>(first_character(text).bytes, 1);
        std::string rest(text.substr(0, bytes));
        text.remove_prefix(bytes);
        if (!line.empty() && !fits(line + rest)) {
            if (const std::size_t space = line.rfind(' '); rest != " " && space != line.npos) {
                rest = line.substr(space + 1) + rest;
                line.resize(space);
            }
            lines.push_back(std::exchange(line, ""));
        }
        if (!line.empty() || rest != " ")
            line += rest;
    }
    if (!line.empty())
        lines.push_back(line);
    return lines;
}

}  // namespace terravox::util
