#pragma once

#include <algorithm>
#include <filesystem>
#include <string>
#include <string_view>

namespace terravox::util {

/// The lower case of ASCII letters; other bytes stay as they are, whatever the locale.
[[nodiscard]] constexpr char lower_case(char c) noexcept {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}
[[nodiscard]] inline std::string lower_case(std::string_view text) {
    std::string out(text);
    std::transform(out.begin(), out.end(), out.begin(), [](char c) { return lower_case(c); });
    return out;
}

/// Whether two texts are equal but for the case of ASCII letters.
[[nodiscard]] inline bool equal_but_for_case(std::string_view a, std::string_view b) noexcept {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                      [](char x, char y) { return lower_case(x) == lower_case(y); });
}

/// The extension of a file's name with its dot, in lower case; empty without one.
[[nodiscard]] inline std::string lower_extension(const std::filesystem::path& file) {
    return lower_case(file.extension().string());
}

}  // namespace terravox::util
