#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

namespace terravox::output {

/// A letter as rows of pixels, 12 from top to bottom: 3 above the capitals, 7 for the letter, 2
/// below the base line.
struct Glyph {
    static constexpr std::size_t kRows = 12;
    std::array<std::uint8_t, kRows> rows{};  ///< bit width - 1 is the leftmost pixel
    int width = 0;                           ///< pixels, 1 to 8; without the gap to the next letter
};

/// Covers ASCII, the letters of Latin-1 and of the languages of Latin Extended-A, and the other
/// characters of attributions (the copyright sign, dashes, quotes). Anything else is a question
/// mark.
[[nodiscard]] Glyph glyph_of(char32_t letter) noexcept;

/// Decodes UTF-8; each invalid byte becomes U+FFFD.
[[nodiscard]] std::u32string letters_of(std::string_view utf8);

}  // namespace terravox::output
