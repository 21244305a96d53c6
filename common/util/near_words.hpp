#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace terravox::util {

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

/// "a, b, c"
[[nodiscard]] std::string comma_list(std::span<const std::string> words);

}  // namespace terravox::util
