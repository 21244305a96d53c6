#pragma once

#include <exception>
#include <string>

namespace terravox::util {

/// The one-line message for an error that ends a program, without the program's name. Standard
/// exceptions that mean a lack of memory or threads are described in plain words.
/// @param error  not null
[[nodiscard]] std::string message_of(const std::exception_ptr& error);

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
