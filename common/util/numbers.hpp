#pragma once

#include <charconv>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>

namespace terravox::util {

/// Takes a character from the front of a text.
/// @return whether it is there
inline bool take(std::string_view& text, char wanted) noexcept {
    if (!text.starts_with(wanted))
        return false;
    text.remove_prefix(1);
    return true;
}

/// Takes a number from the front of a text, whatever follows it.
/// @return nullopt, with the text as it was, where there is none, or one out of range
template <class Number>
[[nodiscard]] std::optional<Number> take_number(std::string_view& text) noexcept {
    Number out{};
    const auto [at, failed] = std::from_chars(text.data(), text.data() + text.size(), out);
    if (failed != std::errc{})
        return std::nullopt;
    text.remove_prefix(static_cast<std::size_t>(at - text.data()));
    return out;
}

/// @return nullopt unless the whole text is a number
template <class Number>
[[nodiscard]] std::optional<Number> parse_number(std::string_view text) noexcept {
    const std::optional<Number> out = take_number<Number>(text);
    return text.empty() ? out : std::nullopt;
}

/// @return I and N of a text "I/N", one of N parts; nullopt unless I is 1 to N
template <class Number>
[[nodiscard]] std::optional<std::pair<Number, Number>> parse_part(std::string_view text) noexcept {
    const std::optional<Number> index = take_number<Number>(text);
    if (!index || !take(text, '/'))
        return std::nullopt;
    const std::optional<Number> count = parse_number<Number>(text);
    if (!count || *index < 1 || *index > *count)
        return std::nullopt;
    return std::pair(*index, *count);
}

}  // namespace terravox::util
