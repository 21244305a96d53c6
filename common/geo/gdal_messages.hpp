#pragma once

#include <cpl_error.h>

namespace terravox::geo {

/// An error handler of GDAL that drops messages. GDAL calls abort() after a message of class
/// CE_Fatal, which it has for too little memory alone: this handler then ends the program with one
/// line on standard error and ExitCode::kFailed before GDAL can do so. Thread-safe.
void CPL_STDCALL drop_gdal_message(CPLErr severity, CPLErrorNum number,
                                   const char* message) noexcept;

/// The same, but messages that do not end the program are printed as GDAL prints them.
void CPL_STDCALL print_gdal_message(CPLErr severity, CPLErrorNum number,
                                    const char* message) noexcept;

/// For error handlers that do more than those above: ends the program as they do when `severity`
/// is CE_Fatal, else does nothing. Needs no memory.
void end_program_if_fatal(CPLErr severity, const char* message) noexcept;

}  // namespace terravox::geo
