#pragma once

#include <span>
#include <string>
#include <string_view>

namespace terravox::worlds {

/// Refuses options of the command line that mean nothing for the kind of world that is opened.
/// @param input names the world in the message
/// @param noun of its kind, with an article (WorldKind::noun)
/// @param suitable flags that the kind takes, separated by spaces; empty: none
/// @param given flags of the command line that belong to some kinds of worlds only
/// @throws UsageError naming the first that does not suit, and those that do
void check_flags(const std::string& input, std::string_view noun, std::string_view suitable,
                 std::span<const std::string> given);

}  // namespace terravox::worlds
