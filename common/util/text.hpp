#pragma once

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

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

/// Number of bytes to insert, to remove, to replace, or to swap with their neighbour ("optimal
/// string alignment": no byte is changed twice) that turn one text into the other.
/// Ref: Damerau, "A technique for computer detection and correction of spelling errors",
/// Communications of the ACM, 1964.
[[nodiscard]] std::size_t edit_distance(std::string_view a, std::string_view b);

/// The words that a mistyped one is probably meant to be: those at the smallest edit_distance(), if
/// this is at most three and less than 60 % of the longer word; else the words that begin with it,
/// if these are at most three. Hyphens in front and the case of letters do not count. The grabber's
/// library (commander) has the same limits.
/// @return equally near ones, in the order of `known`; none where no word is near
[[nodiscard]] std::vector<std::string> near_words(std::string_view mistyped,
                                                  std::span<const std::string> known);

/// For the end of a message: "; did you mean render?", "; did you mean a, b or c?"
/// @param near not empty
[[nodiscard]] std::string did_you_mean(std::span<const std::string> near);

/// The same with the near_words() of a mistyped one; "" where there are none.
[[nodiscard]] std::string did_you_mean(std::string_view mistyped,
                                       std::span<const std::string> known);

/// The same with all words: "; did you mean path? allowed: direct, path", "; allowed: direct,
/// path".
[[nodiscard]] std::string allowed_words(std::string_view mistyped,
                                        std::span<const std::string> known);

/// Without spaces, tabs and ends of lines before and behind it.
[[nodiscard]] std::string_view trimmed(std::string_view text) noexcept;

/// The shortest text that reads back as the same number, whatever the locale: "0.1", "1e+05".
[[nodiscard]] std::string number_text(double value);
[[nodiscard]] std::string number_text(float value);
/// @param digits at most so many count: "%.6g" of the C locale
[[nodiscard]] std::string number_text(double value, int digits);
/// As number_text(), but without an exponent where that takes no more than 40 characters.
[[nodiscard]] std::string plain_number_text(double value);

/// "a, b, c"
[[nodiscard]] std::string comma_list(std::span<const std::string> words);

/// Whole numbers from `first` to `last`, both included.
struct IntRange {
    int first = 0;
    int last = 0;
    [[nodiscard]] int count() const noexcept { return last - first + 1; }
    bool operator==(const IntRange&) const = default;
};

/// Parses "4-9" or "4".
/// @param what begins the message
/// @throws UsageError outside `allowed`
[[nodiscard]] IntRange parse_range(const std::string& what, const std::string& text,
                                   IntRange allowed);

/// Makes untrusted text safe for one line of a terminal or a log: it cannot move the cursor, change
/// a colour or reorder the text around it. Control characters (C0, DEL, C1), line separators,
/// bidirectional marks and overrides, and bytes that are not valid UTF-8 become visible escapes:
/// `\n`, `\r`, `\t`, `\x1b`, `\u202e`. All other UTF-8 is unchanged; a backslash is not doubled, so
/// that paths stay readable.
[[nodiscard]] std::string printable(std::string_view text);

/// A text as it must stand in HTML or XML, within an element or a quoted attribute.
[[nodiscard]] inline std::string escaped_markup(std::string_view text) {
    std::string out;
    for (const char c : text) {
        switch (c) {
            case '&': out += "&amp;"; break;
            case '<': out += "&lt;"; break;
            case '>': out += "&gt;"; break;
            case '"': out += "&quot;"; break;
            default: out += c; break;
        }
    }
    return out;
}

/// Quotes a word so that bash reads it back byte for byte, including quotes, blanks, dollars, line
/// breaks and bytes that are not valid UTF-8. The result is one line without control characters,
/// because Slurm refuses scripts that contain a carriage return.
/// @throws UsageError for a word with a zero byte, which cannot be passed to a program
[[nodiscard]] std::string shell_word(std::string_view word);

/// An array definition: `name=(`, a line for each word, `)`; a script expands it with "${name[@]}".
[[nodiscard]] std::string shell_array(std::string_view name, std::span<const std::string> words);

/// Makes text safe for a one-line comment of a script: control characters become '?', and it is
/// truncated to 100 bytes.
[[nodiscard]] std::string comment_text(std::string_view text);

}  // namespace terravox::util
