#pragma once

#include <string>
#include <string_view>

namespace terravox::util {

/// Text of a stranger for one line of a terminal or a log: nothing in it moves the cursor, changes
/// a colour or reorders what stands beside it. Control characters (C0, DEL, C1), line separators,
/// marks and overrides of the writing direction, and bytes that are no UTF-8 become visible
/// escapes: `\n`, `\r`, `\t`, `\x1b`, `\u202e`. All other UTF-8 stays as it is; a backslash is not
/// doubled, so that paths stay readable.
[[nodiscard]] std::string printable(std::string_view text);

}  // namespace terravox::util
