#pragma once

#include <span>
#include <string>
#include <string_view>

namespace terravox::util {

/// A word as bash reads it back, byte for byte: quotes, blanks, dollars, line breaks and bytes that
/// are no UTF-8 included. One line without control characters, because Slurm refuses scripts in
/// which a carriage return stands.
/// @throws UsageError for a word with a zero byte: no program can be given one
[[nodiscard]] std::string shell_word(std::string_view word);

/// `name=(` and a line for each word, `)`: what a script calls as "${name[@]}".
[[nodiscard]] std::string shell_array(std::string_view name, std::span<const std::string> words);

/// For a comment of a script, which must stay one line: control characters become '?', and it ends
/// after 100 bytes.
[[nodiscard]] std::string comment_text(std::string_view text);

}  // namespace terravox::util
