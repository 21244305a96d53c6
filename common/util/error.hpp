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

/// The unit of work (request, tile, file, run) cannot continue. The message is one line: attempt,
/// object, value, allowed range.
class Error : public std::runtime_error {
public:
    explicit Error(const std::string& message) : std::runtime_error(message) {}
    [[nodiscard]] virtual ExitCode exit_code() const noexcept { return ExitCode::kFailed; }
};

/// The user's request is invalid: an unknown flag, a value out of range, a missing CRS.
class UsageError : public Error {
public:
    using Error::Error;
    [[nodiscard]] ExitCode exit_code() const noexcept override { return ExitCode::kUsage; }
};

}  // namespace terravox::util
