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

void say(const char* text) noexcept {
    const std::size_t length = std::char_traits<char>::length(text);
    // Standard error may be closed: there is nobody left to tell.
    [[maybe_unused]] const auto written = ::write(STDERR_FILENO, text, length);
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
    say("\n");
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
