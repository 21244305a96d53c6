#pragma once

#include <spdlog/spdlog.h>

#include <string>

namespace terravox::util {

enum class LogFormat {
    kText,  ///< `[level] message`, coloured only on a terminal
    kJson,  ///< an object: time (UTC, ISO 8601), level, message
};

/// Sends the log to standard error, exactly one line per message; special characters in messages
/// are escaped (printable.hpp).
/// @param level trace, debug, info, warn, error or off
/// @throws UsageError for another level
void set_up_log(const std::string& level, LogFormat format = LogFormat::kText);

}  // namespace terravox::util
