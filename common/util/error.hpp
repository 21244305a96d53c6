#pragma once

#include <fmt/core.h>

#include <exception>
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

[[nodiscard]] std::string write_message(fmt::string_view format, fmt::format_args arguments);

/// The unit of work (request, tile, file, run) cannot continue. The message is one line: attempt,
/// object, value, allowed range.
class Error : public std::runtime_error {
public:
    explicit Error(const std::string& message) : std::runtime_error(with_visible_zeros(message)) {}
    /// The message in the syntax of the library fmt.
    template <class First, class... More>
    explicit Error(fmt::format_string<First, More...> format, First&& first, More&&... more)
        : Error(write_message(format, fmt::make_format_args(first, more...))) {}
    [[nodiscard]] virtual ExitCode exit_code() const noexcept { return ExitCode::kFailed; }
};

/// The user's request is invalid: an unknown flag, a value out of range, a missing CRS.
class UsageError : public Error {
public:
    using Error::Error;
    [[nodiscard]] ExitCode exit_code() const noexcept override { return ExitCode::kUsage; }
};

/// The one-line message for an error that ends a program, without the program's name. Standard
/// exceptions that mean a lack of memory or threads are described in plain words.
/// @param error  not null
[[nodiscard]] std::string to_message(const std::exception_ptr& error);

/// Installs a terminate handler: from now on an uncaught exception (in a thread, a destructor, a
/// callback of a C library) ends the program with one line on standard error and ExitCode::kFailed,
/// as run_program does, instead of by a signal. Destructors do not run: unfinished files keep their
/// temporary names, as after a kill. Also loads now what the C library needs to pass exceptions on,
/// since without memory it could not be loaded any more. Must be called once, before threads are
/// started.
void end_with_a_line_on_uncaught_exceptions() noexcept;

/// Ends the program at once with the line "terravox: attempt: reason" on standard error and
/// ExitCode::kFailed: for libraries that call abort() when their error handler returns. Allocates
/// no memory; when several threads call it, only the first one's line is printed. Destructors do
/// not run.
/// @param attempt, reason  not null; characters beyond printable ASCII are shown as '?'
[[noreturn]] void end_program(const char* attempt, const char* reason) noexcept;

}  // namespace terravox::util
