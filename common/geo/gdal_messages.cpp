#include "common/geo/gdal_messages.hpp"

#include <dlfcn.h>

#include <atomic>
#include <csignal>
#include <cstdarg>
#include <cstdio>
#include <new>
#include <string>

#include "common/util/error.hpp"
#include "common/util/text.hpp"

namespace terravox::geo {
namespace {

constexpr const char* kAttempt = "GDAL cannot go on";

using Handler = void (*)(int);

// Of the model that needs no memory at the first use in a thread.
[[gnu::tls_model("initial-exec")]] thread_local bool t_memory_was_missing = false;
std::atomic<Handler> s_former_handler = SIG_DFL;

extern "C" void end_program_if_memory_was_missing(int signal) {
    if (t_memory_was_missing)
        util::end_program(kAttempt, "out of memory");
    const Handler former = s_former_handler;
    if (former != SIG_DFL && former != SIG_IGN)
        former(signal);
    // After a return from here, abort() ends the program by its signal, as without a handler.
}

// libtiff's TIFFErrorHandler, and the function that sets it. libtiff is GDAL's affair: the one that
// it has brought is asked, and none is linked.
using TiffHandler = void (*)(const char* module, const char* format, std::va_list arguments);
using SetTiffHandler = TiffHandler (*)(TiffHandler handler);

void pass_on(CPLErr severity, const char* module, const char* format,
             std::va_list arguments) noexcept {
    char text[1000];
    std::vsnprintf(text, sizeof text, format, arguments);
    CPLError(severity, CPLE_AppDefined, "%s: %s", module != nullptr ? module : "libtiff", text);
}

extern "C" void pass_tiff_error(const char* module, const char* format,
                                std::va_list arguments) noexcept {
    pass_on(CE_Failure, module, format, arguments);
}

extern "C" void pass_tiff_warning(const char* module, const char* format,
                                  std::va_list arguments) noexcept {
    pass_on(CE_Warning, module, format, arguments);
}

void set_tiff_handler(const char* function, TiffHandler handler) noexcept {
    if (const auto set = reinterpret_cast<SetTiffHandler>(::dlsym(RTLD_DEFAULT, function)))
        set(handler);
}

}  // namespace

void take_tiff_messages() noexcept {
    set_tiff_handler("TIFFSetErrorHandler", pass_tiff_error);
    set_tiff_handler("TIFFSetWarningHandler", pass_tiff_warning);
}

void CPL_STDCALL drop_gdal_message(CPLErr severity, CPLErrorNum number,
                                   const char* message) noexcept {
    end_program_if_fatal(severity, number, message);
}

void CPL_STDCALL print_gdal_message(CPLErr severity, CPLErrorNum number,
                                    const char* message) noexcept {
    end_program_if_fatal(severity, number, message);
    try {
        const std::string text = util::printable(message != nullptr ? message : "no reason given");
        CPLDefaultErrorHandler(severity, number, text.c_str());
    } catch (const std::bad_alloc&) {  // The function that failed tells so by what it returns.
    }
}

void end_program_if_fatal(CPLErr severity, CPLErrorNum number, const char* message) noexcept {
    if (severity == CE_Fatal)
        util::end_program(kAttempt, message != nullptr ? message : "no reason given");
    // Most of GDAL then returns an error, but some functions for lists of strings call abort().
    if (number == CPLE_OutOfMemory) {
        t_memory_was_missing = true;
        const Handler former = std::signal(SIGABRT, end_program_if_memory_was_missing);
        if (former != end_program_if_memory_was_missing && former != SIG_ERR)
            s_former_handler = former;
    }
}

void forget_missing_memory() noexcept {
    t_memory_was_missing = false;
}

}  // namespace terravox::geo
