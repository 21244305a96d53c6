#include "common/util/text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <utility>

#include "common/util/error.hpp"
#include "common/util/utf8.hpp"

namespace terravox::util {
namespace {

constexpr std::size_t kMostEdits = 3;
constexpr std::size_t kMostWords = 3;
/// Of a word's beginning, for words that begin so.
constexpr std::size_t kFewestLetters = 3;

/// Without hyphens in front, in lower case.
std::string bare(std::string_view word) {
    const std::size_t from = word.find_first_not_of('-');
    return from == std::string_view::npos ? std::string{} : lower_case(word.substr(from));
}

/// Whether so few edits leave enough in common.
bool is_near(std::size_t edits, std::size_t longer) {
    return edits <= kMostEdits && 5 * edits < 3 * longer;
}

std::vector<std::string> words_that_begin_with(std::string_view beginning,
                                               std::span<const std::string> known) {
    if (beginning.size() < kFewestLetters)
        return {};
    std::vector<std::string> out;
    for (const std::string& word : known)
        if (bare(word).starts_with(beginning))
            out.push_back(word);
    return out.size() <= kMostWords ? out : std::vector<std::string>{};
}

}  // namespace

std::size_t edit_distance(std::string_view a, std::string_view b) {
    // Rows of the table of distances between the beginnings of a and b: the last two, and this one.
    std::vector<std::size_t> before_last;
    std::vector<std::size_t> last(b.size() + 1);
    for (std::size_t j = 0; j <= b.size(); ++j)
        last[j] = j;
    for (std::size_t i = 1; i <= a.size(); ++i) {
        std::vector<std::size_t> row(b.size() + 1);
        row[0] = i;
        for (std::size_t j = 1; j <= b.size(); ++j) {
            const std::size_t replaced = last[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
            row[j] = std::min({last[j] + 1, row[j - 1] + 1, replaced});
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
                row[j] = std::min(row[j], before_last[j - 2] + 1);
        }
        before_last = std::move(last);
        last = std::move(row);
    }
    return last[b.size()];
}

std::vector<std::string> near_words(std::string_view mistyped, std::span<const std::string> known) {
    const std::string typed = bare(mistyped);
    std::size_t fewest = kMostEdits + 1;
    std::vector<std::string> out;
    for (const std::string& word : known) {
        const std::string candidate = bare(word);
        const std::size_t longer = std::max(typed.size(), candidate.size());
        // The difference in length is a lower bound of the edits.
        if (longer - std::min(typed.size(), candidate.size()) > std::min(fewest, kMostEdits))
            continue;
        const std::size_t edits = edit_distance(typed, candidate);
        if (edits > fewest || !is_near(edits, longer))
            continue;
        if (edits < fewest)
            out.clear();
        fewest = edits;
        out.push_back(word);
    }
    return out.empty() ? words_that_begin_with(typed, known) : out;
}

std::string did_you_mean(std::span<const std::string> near) {
    std::string out = "; did you mean " + comma_list(near.first(near.size() - 1));
    return out + (near.size() > 1 ? " or " : "") + near.back() + "?";
}

std::string did_you_mean(std::string_view mistyped, std::span<const std::string> known) {
    const std::vector<std::string> near = near_words(mistyped, known);
    return near.empty() ? std::string{} : did_you_mean(near);
}

std::string allowed_words(std::string_view mistyped, std::span<const std::string> known) {
    const std::string meant = did_you_mean(mistyped, known);
    return (meant.empty() ? ";" : meant) + " allowed: " + comma_list(known);
}

namespace {

/// @param form none, or format and precision of std::to_chars
template <class Number, class... Form>
std::string write_number(Number value, Form... form) {
    std::array<char, 40> text{};
    const auto end = std::to_chars(text.data(), text.data() + text.size(), value, form...);
    return end.ec == std::errc{} ? std::string(text.data(), end.ptr) : std::string();
}

}  // namespace

std::string_view trimmed(std::string_view text) noexcept {
    constexpr std::string_view kBlank = " \t\r\n";
    const std::size_t begin = text.find_first_not_of(kBlank);
    if (begin == std::string_view::npos)
        return {};
    return text.substr(begin, text.find_last_not_of(kBlank) - begin + 1);
}

std::string number_text(double value) {
    return write_number(value);
}

std::string number_text(float value) {
    return write_number(value);
}

std::string number_text(double value, int digits) {
    return write_number(value, std::chars_format::general, digits);
}

std::string plain_number_text(double value) {
    const std::string plain = write_number(value, std::chars_format::fixed);
    return plain.empty() ? number_text(value) : plain;
}

std::string comma_list(std::span<const std::string> words) {
    std::string out;
    for (const std::string& word : words)
        out += (out.empty() ? "" : ", ") + word;
    return out;
}

IntRange parse_range(const std::string& what, const std::string& text, IntRange allowed) {
    IntRange out{-1, -1};
    const char *begin = text.data(), *end = begin + text.size();
    auto read = std::from_chars(begin, end, out.first);
    if (read.ec == std::errc{} && read.ptr == end)
        out.last = out.first;
    else if (read.ec == std::errc{} && *read.ptr == '-') {
        read = std::from_chars(read.ptr + 1, end, out.last);
        if (read.ec != std::errc{} || read.ptr != end)
            out.last = -1;
    }
    if (begin == end || out.first < allowed.first || out.last < out.first ||
        out.last > allowed.last)
        throw UsageError("{} {}; allowed: one number or two with a dash between, from {} to {}",
                         what, text, allowed.first, allowed.last);
    return out;
}

namespace {

bool is_harmful(char32_t code) noexcept {
    if (code < 0x20 || (code >= 0x7f && code < 0xa0))
        return true;  // C0, DEL, C1
    if (code == 0x2028 || code == 0x2029)
        return true;  // line and paragraph separators
    if (code == 0x061c || code == 0x200e || code == 0x200f)
        return true;  // bidirectional marks
    return (code >= 0x202a && code <= 0x202e) ||
           (code >= 0x2066 && code <= 0x2069);  // embeddings, overrides, isolates
}

std::string make_escape(char32_t code) {
    if (code == '\n')
        return "\\n";
    if (code == '\r')
        return "\\r";
    if (code == '\t')
        return "\\t";
    const auto number = static_cast<std::uint32_t>(code);
    return number <= 0x7f ? fmt::format("\\x{:02x}", number) : fmt::format("\\u{:04x}", number);
}

}  // namespace

std::string printable(std::string_view text) {
    std::string out;
    out.reserve(text.size());
    while (!text.empty()) {
        const Character c = first_character(text);
        if (c.bytes == 0) {
            out += fmt::format("\\x{:02x}", static_cast<unsigned char>(text.front()));
            text.remove_prefix(1);
            continue;
        }
        if (is_harmful(c.code))
            out += make_escape(c.code);
        else
            out += text.substr(0, c.bytes);
        text.remove_prefix(c.bytes);
    }
    return out;
}

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
