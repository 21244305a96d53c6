#pragma once

#include <span>
#include <string>
#include <string_view>

namespace terravox::util {

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
