#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace terravox::commands {

/// Reads the numbers of a flag, separated by commas.
/// @param allowed the expected text, for messages
/// @return `count` finite numbers; none where the text is empty
/// @throws UsageError "COMMAND: FLAG TEXT; allowed: ..."
[[nodiscard]] std::vector<double> numbers_of(const std::string& command, const std::string& flag,
                                             const std::string& text, std::size_t count,
                                             const std::string& allowed);

}  // namespace terravox::commands
