#pragma once

#include <stdexcept>
#include <string>

namespace terravox::util {

/// The exit codes shared by all programs of the project.
enum class ExitCode : int {
    kDone = 0,
    kFailed = 1,
    kUsage = 2,
    kHoles = 3,  ///< finished, but with reported holes (missing squares or boxes)
};

/// Makes bytes of zero visible, at the first of which what() would end: a name of a stranger's may
/// have one, and must not hide the rest of the message.
[[nodiscard]] inline std::string with_visible_zeros(std::string text) {
    for (std::size_t at = 0; (at = text.find('\0', at)) != std::string::npos;)
        text.replace(at, 1, "\\x00");
    return text;
}

/// The unit of work (request, tile, file, run) cannot continue. The message is one line: attempt,
/// object, value, allowed range.
class Error : public std::runtime_error {
public:
    explicit Error(const std::string& message) : std::runtime_error(with_visible_zeros(message)) {}
    [[nodiscard]] virtual ExitCode exit_code() const noexcept { return ExitCode::kFailed; }
};

/// The user's request is invalid: an unknown flag, a value out of range, a missing CRS.
class UsageError : public Error {
public:
    using Error::Error;
    [[nodiscard]] ExitCode exit_code() const noexcept override { return ExitCode::kUsage; }
};

}  // namespace terravox::util
