#pragma once

#include <cpl_error.h>
#include <algorithm>
#include <string>

namespace terravox::geo {

/// A GDAL error handler that drops messages. GDAL calls abort() after a message of class CE_Fatal,
/// which it emits only when out of memory: this handler then ends the program with one line on
/// standard error and ExitCode::kFailed before GDAL can do so. It does the same when a thread calls
/// abort() after a message of another class that says that memory is missing, until
/// forget_missing_memory(). Thread-safe.
void CPL_STDCALL drop_gdal_message(CPLErr severity, CPLErrorNum number,
                                   const char* message) noexcept;

/// Like drop_gdal_message(), but prints messages that do not end the program as GDAL prints them,
/// each on one line: since they quote files, special characters are escaped
/// (common/util/text.hpp).
void CPL_STDCALL print_gdal_message(CPLErr severity, CPLErrorNum number,
                                    const char* message) noexcept;

/// For custom error handlers: ends the program now or on abort(), as the handlers above do, else
/// does nothing. Allocates no memory.
void end_program_if_fatal(CPLErr severity, CPLErrorNum number, const char* message) noexcept;

/// Makes messages of libtiff that belong to no open file GDAL's, as GDAL made them itself until it
/// gave each file handlers of its own: libtiff would print them. Does nothing where GDAL's libtiff
/// is inside of it and cannot be reached. Not thread-safe.
void take_tiff_messages() noexcept;

/// To be called on the same thread when GDAL has returned: from now on abort() has other reasons.
void forget_missing_memory() noexcept;

/// RAII guard: during its lifetime GDAL's messages on this thread are kept for our own errors
/// instead of being printed to standard error.
class GdalErrorScope {
public:
    GdalErrorScope() {
        CPLPushErrorHandler(drop_gdal_message);
        CPLErrorReset();
    }
    ~GdalErrorScope() {
        CPLPopErrorHandler();
        forget_missing_memory();
    }
    GdalErrorScope(const GdalErrorScope&) = delete;
    GdalErrorScope& operator=(const GdalErrorScope&) = delete;

    /// GDAL's last message as one line.
    [[nodiscard]] static std::string reason() {
        std::string text = CPLGetLastErrorMsg();
        std::replace(text.begin(), text.end(), '\n', ' ');
        return text.empty() ? "no reason given" : text;
    }
};

}  // namespace terravox::geo
