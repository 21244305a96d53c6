#pragma once

#include <span>
#include <string>
#include <string_view>

namespace terravox::worlds {

/// Rejects command-line options that do not apply to the kind of world that is opened.
/// @param input names the world in the message
/// @param noun of its kind, with an article (WorldKind::noun)
/// @param suitable flags that apply to the kind, separated by spaces; empty: none
/// @param given command-line flags that apply to some kinds of worlds only
/// @throws UsageError naming the first that does not apply, and those that do
void check_flags(const std::string& input, std::string_view noun, std::string_view suitable,
                 std::span<const std::string> given);

}  // namespace terravox::worlds
