#pragma once

#include <string>
#include <string_view>

namespace terravox::util {

/// Makes untrusted text safe for one line of a terminal or a log: it cannot move the cursor, change
/// a colour or reorder the text around it. Control characters (C0, DEL, C1), line separators,
/// bidirectional marks and overrides, and bytes that are not valid UTF-8 become visible escapes:
/// `\n`, `\r`, `\t`, `\x1b`, `\u202e`. All other UTF-8 is unchanged; a backslash is not doubled, so
/// that paths stay readable.
[[nodiscard]] std::string printable(std::string_view text);

}  // namespace terravox::util
