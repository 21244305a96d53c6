#include "common/util/end_of_program.hpp"

#include <unistd.h>

#include <cstdlib>
#include <new>
#include <system_error>

#include "common/util/error.hpp"

namespace terravox::util {
namespace {

constexpr const char* kOutOfMemory = "out of memory; lower memory limits or a smaller task may help";
constexpr const char* kName = "terravox: ";

/// The text of an error without any allocation; `text` is what the exception itself says, where that is to be used.
const char* plain_message_of(const std::exception_ptr& error, const char* text) noexcept {
    try {
        std::rethrow_exception(error);
    } catch (const std::bad_alloc&) {
        return kOutOfMemory;
    } catch (const std::system_error& e) {
        // What std::thread throws where the system refuses one: it lacks memory for the stack, or a limit is reached.
        if (e.code() == std::errc::resource_unavailable_try_again) {
            return "the system gives no more threads or memory; "
                   "fewer threads or higher limits of the system may help";
        }
        return text;
    } catch (...) {
        return text;
    }
}

// Plain ASCII alone, a character at a time: the text may be a stranger's, and printable() needs memory.
void say(const char* text) noexcept {
    for (; *text != '\0'; ++text) {
        const char shown = *text >= ' ' && *text < '\x7f' ? *text : '?';
        // Standard error may be closed: nothing is left to be done then.
        [[maybe_unused]] const auto written = ::write(STDERR_FILENO, &shown, 1);
    }
}

[[noreturn]] void end_program() noexcept {
    const char* message = "ended by an error inside the program that carries no message";
    // Whatever is done here must need no memory: its lack may be the reason.
    if (const std::exception_ptr error = std::current_exception()) {
        try {
            std::rethrow_exception(error);
        } catch (const std::exception& e) {
            message = plain_message_of(error, e.what());
        } catch (...) {
        }
    }
    say(kName);
    say(message);
    [[maybe_unused]] const auto written = ::write(STDERR_FILENO, "\n", 1);
    std::_Exit(static_cast<int>(ExitCode::kFailed));
}

}  // namespace

std::string message_of(const std::exception_ptr& error) {
    try {
        std::rethrow_exception(error);
    } catch (const std::exception& e) {
        return plain_message_of(error, e.what());
    } catch (...) {
        return "an error that carries no message";
    }
}

void end_with_a_line_on_uncaught_exceptions() noexcept { std::set_terminate(end_program); }

}  // namespace terravox::util
