#include "common/util/shell_words.hpp"

#include <algorithm>

#include "common/util/error.hpp"

namespace terravox::util {
namespace {

bool is_control(char c) noexcept {
    return static_cast<unsigned char>(c) < 0x20 || c == 0x7f;
}

bool is_plain(char c) noexcept {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
           std::string_view("_-./:,@%+").find(c) != std::string_view::npos;
}

}  // namespace

std::string shell_word(std::string_view word) {
    if (word.find('\0') != std::string_view::npos)
        throw UsageError("write a script: an argument has a zero byte; allowed: all others");
    if (!word.empty() && std::all_of(word.begin(), word.end(), is_plain))
        return std::string(word);
    const bool controls = std::any_of(word.begin(), word.end(), is_control);
    std::string out = controls ? "$'" : "'";
    for (const char c : word) {
        if (controls && is_control(c)) {
            const auto code = static_cast<unsigned char>(c);
            out += {'\\', static_cast<char>('0' + (code >> 6)),
                    static_cast<char>('0' + (code >> 3 & 7)), static_cast<char>('0' + (code & 7))};
        } else if (controls && (c == '\'' || c == '\\'))
            out += {'\\', c};
        else if (c == '\'')
            out += "'\\''";
        else
            out += c;
    }
    return out + "'";
}

std::string shell_array(std::string_view name, std::span<const std::string> words) {
    std::string out = std::string(name) + "=(\n";
    for (const std::string& word : words)
        out += "    " + shell_word(word) + "\n";
    return out + ")\n";
}

std::string comment_text(std::string_view text) {
    constexpr std::size_t kMax_bytes = 100;
    std::string out(text.substr(0, kMax_bytes));
    std::replace_if(out.begin(), out.end(), is_control, '?');
    return text.size() > kMax_bytes ? out + " ..." : out;
}

}  // namespace terravox::util
