#pragma once

#include <fmt/core.h>

#include <cstdint>
#include <string>

namespace terravox::util {

enum class LogFormat {
    kText,  ///< `[level] message`, coloured only on a terminal
    kJson,  ///< an object: time (UTC, ISO 8601), level, message
};

/// Sends the log to standard error, exactly one line per message; special characters in messages
/// are escaped (text.hpp).
/// @param level trace, debug, info, warn, error or off
/// @throws UsageError for another level
void set_up_log(const std::string& level, LogFormat format = LogFormat::kText);

enum class LogLevel : std::uint8_t { kTrace, kDebug, kInfo, kWarning, kError, kCritical };

/// Whether messages of this level are written. Thread-safe.
[[nodiscard]] bool is_logged(LogLevel level);

/// Writes a message whose arguments have lost their types. Thread-safe. A message that cannot be
/// formatted or written is replaced by a line that says so.
void write_log(LogLevel level, fmt::string_view format, fmt::format_args arguments) noexcept;

/// Writes a message, in the syntax of the library fmt. The logging library itself is included by
/// log.cpp alone: compiling its headers takes longer than most sources that log.
template <class... Arguments>
void log_message(LogLevel level, fmt::format_string<Arguments...> format,
                 Arguments&&... arguments) {
    write_log(level, format, fmt::make_format_args(arguments...));
}

template <class... Arguments>
void log_trace(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
    write_log(LogLevel::kTrace, format, fmt::make_format_args(arguments...));
}
template <class... Arguments>
void log_debug(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
    write_log(LogLevel::kDebug, format, fmt::make_format_args(arguments...));
}
template <class... Arguments>
void log_info(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
    write_log(LogLevel::kInfo, format, fmt::make_format_args(arguments...));
}
template <class... Arguments>
void log_warn(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
    write_log(LogLevel::kWarning, format, fmt::make_format_args(arguments...));
}
template <class... Arguments>
void log_error(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
    write_log(LogLevel::kError, format, fmt::make_format_args(arguments...));
}

/// Warns of something that many files of a run may share. Of the first file it is said at once;
/// later ones with the same fact are counted, and say_shared_warnings() tells of them in one line.
/// Thread-safe.
/// @param fact the same words for all files
/// @param detail what is true of this file only, in brackets behind the fact; may be empty
void warn_of_file(const std::string& file, const std::string& fact, const std::string& detail = {});

/// Says how many other files each fact of warn_of_file() was true of, and forgets them, so that the
/// next file is warned of anew. Called before and after a world is opened, when one is closed, and
/// by programs at their end.
void say_shared_warnings() noexcept;

}  // namespace terravox::util
