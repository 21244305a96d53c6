#pragma once

#include <spdlog/spdlog.h>

#include <string>

namespace terravox::util {

/// Sends the log to standard error, one line a message: `[level] message`, coloured only on a terminal.
/// @param level trace, debug, info, warn, error or off
/// @throws UsageError for another level
void set_up_log(const std::string& level);

}  // namespace terravox::util
