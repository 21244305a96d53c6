#pragma once

#include <exception>
#include <string>

namespace terravox::util {

/// The line that a person is told of an error that ends a program, without the program's name.
/// Exceptions of the standard library that mean a lack of memory or threads say so in plain words.
/// @param error  not null
[[nodiscard]] std::string message_of(const std::exception_ptr& error);

/// From now on an exception that nobody catches (in a thread, a destructor, a callback of a C
/// library) ends the program with one line on standard error and ExitCode::kFailed, as run_program
/// does, instead of by a signal. Destructors do not run: files that were not finished keep their
/// temporary names, as after a kill. To be called once, before threads are started.
void end_with_a_line_on_uncaught_exceptions() noexcept;

/// Ends the program at once with the line "terravox: attempt: reason" on standard error and
/// ExitCode::kFailed: for libraries that call abort() when their error handler returns. Needs no
/// memory; of several threads the first one's line is printed. Destructors do not run.
/// @param attempt, reason  not null; characters beyond printable ASCII are shown as '?'
[[noreturn]] void end_program(const char* attempt, const char* reason) noexcept;

}  // namespace terravox::util
