#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace terravox::util {

struct Character {
    std::size_t bytes = 0;  ///< 0: not valid UTF-8
    char32_t code = 0;
};

/// The first character of a text in UTF-8.
/// @param text not empty
[[nodiscard]] Character first_character(std::string_view text) noexcept;

/// Appends a character.
/// @param code up to 0x1fffff
void append_utf8(std::string& out, char32_t code);

/// Lines of a text in UTF-8, broken at spaces, or within a word that is too long for a line.
/// @param fits whether a line is short enough; a single character always is
[[nodiscard]] std::vector<std::string> broken_lines(
    std::string_view text, const std::function<bool(const std::string&)>& fits);

}  // namespace terravox::util
