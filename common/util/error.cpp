#include "common/util/error.hpp"

#include <execinfo.h>
#include <unistd.h>
#include <atomic>
#include <cstdlib>
#include <initializer_list>
#include <new>
#include <system_error>
#include <utility>

namespace terravox::util {
namespace {

constexpr const char* kOutOfMemory =
    "out of memory; lower memory limits or a smaller task may help";
constexpr const char* kName = "terravox: ";

/// The text of an error without any allocation; `text` is the exception's own message, where that
/// is to be used.
const char* to_plain_message(const std::exception_ptr& error, const char* text) noexcept {
    try {
        std::rethrow_exception(error);
    } catch (const std::bad_alloc&) {
        return kOutOfMemory;
    } catch (const std::system_error& e) {
        // Thrown by std::thread when the system refuses a thread: it lacks memory for the stack, or
        // a limit is reached.
        if (e.code() == std::errc::resource_unavailable_try_again) {
            return "the system gives no more threads or memory; "
                   "fewer threads or higher limits of the system may help";
        }
        return text;
    } catch (...) {
        return text;
    }
}

// Standard error may be closed: nothing can be done about that.
void write_out(const char* text, std::size_t bytes) noexcept {
    [[maybe_unused]] const auto written = ::write(STDERR_FILENO, text, bytes);
}

// Plain ASCII only: the text may be untrusted, and printable() needs memory. A line of usual length
// is a single write, so that the output of other threads cannot interrupt it.
void say(std::initializer_list<const char*> parts) noexcept {
    char line[1024];
    std::size_t used = 0;
    const auto add = [&](char c) {
        line[used++] = c;
        if (used == sizeof line)
            write_out(line, std::exchange(used, 0));
    };
    for (const char* part : parts)
        for (const char* c = part; *c != '\0'; ++c)
            add(*c >= ' ' && *c < '\x7f' ? *c : '?');
    add('\n');
    write_out(line, used);
}

// When memory runs out, several threads may get here at once: the first ends the program, the
// others wait for that. A thread that enters a second time has failed inside this function.
void end_as_the_only_one() noexcept {
    static std::atomic_flag s_ending;
    static thread_local bool s_here = false;
    if (std::exchange(s_here, true))
        std::_Exit(static_cast<int>(ExitCode::kFailed));
    while (s_ending.test_and_set())
        ::pause();
}

[[noreturn]] void end_by_exception() noexcept {
    end_as_the_only_one();
    const char* message = "ended by an error inside the program that carries no message";
    // Nothing here may allocate memory: its lack may be the reason for the call.
    if (const std::exception_ptr error = std::current_exception()) {
        try {
            std::rethrow_exception(error);
        } catch (const std::exception& e) {
            message = to_plain_message(error, e.what());
        } catch (...) {
        }
    }
    say({kName, message});
    std::_Exit(static_cast<int>(ExitCode::kFailed));
}

// An exception that leaves std::call_once passes through pthread_once(), and the C library loads
// libgcc_s by name for such frames of its own when the first exception gets there. Without memory
// for that it calls abort(). backtrace() is its documented way to load the library early.
void load_unwinder() noexcept {
    void* frame = nullptr;
    [[maybe_unused]] const int frames = ::backtrace(&frame, 1);
}

}  // namespace

std::string write_message(fmt::string_view format, fmt::format_args arguments) {
    return fmt::vformat(format, arguments);
}

std::string to_message(const std::exception_ptr& error) {
    try {
        std::rethrow_exception(error);
    } catch (const std::exception& e) {
        return to_plain_message(error, e.what());
    } catch (...) {
        return "an error that carries no message";
    }
}

void end_program(const char* attempt, const char* reason) noexcept {
    end_as_the_only_one();
    say({kName, attempt, ": ", reason});
    std::_Exit(static_cast<int>(ExitCode::kFailed));
}

void end_with_a_line_on_uncaught_exceptions() noexcept {
    load_unwinder();
    std::set_terminate(end_by_exception);
}

}  // namespace terravox::util
