#include "common/geo/gdal_messages.hpp"

#include <csignal>

#include "common/util/end_of_program.hpp"

namespace terravox::geo {
namespace {

constexpr const char* kAttempt = "GDAL cannot go on";

thread_local bool t_memory_was_missing = false;

extern "C" void end_program_if_memory_was_missing(int) {
    // After a return from here, abort() ends the program by its signal, as without a handler.
    if (t_memory_was_missing)
        util::end_program(kAttempt, "out of memory");
}

}  // namespace

void CPL_STDCALL drop_gdal_message(CPLErr severity, CPLErrorNum number,
                                   const char* message) noexcept {
    end_program_if_fatal(severity, number, message);
}

void CPL_STDCALL print_gdal_message(CPLErr severity, CPLErrorNum number,
                                    const char* message) noexcept {
    end_program_if_fatal(severity, number, message);
    CPLDefaultErrorHandler(severity, number, message);
}

void end_program_if_fatal(CPLErr severity, CPLErrorNum number, const char* message) noexcept {
    if (severity == CE_Fatal)
        util::end_program(kAttempt, message != nullptr ? message : "no reason given");
    // Most of GDAL then returns an error, but some functions for lists of strings call abort().
    if (number == CPLE_OutOfMemory) {
        t_memory_was_missing = true;
        std::signal(SIGABRT, end_program_if_memory_was_missing);
    }
}

}  // namespace terravox::geo
