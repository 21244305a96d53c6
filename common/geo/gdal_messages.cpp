#include "common/geo/gdal_messages.hpp"

#include "common/util/end_of_program.hpp"

namespace terravox::geo {

void CPL_STDCALL drop_gdal_message(CPLErr severity, CPLErrorNum, const char* message) noexcept {
    end_program_if_fatal(severity, message);
}

void CPL_STDCALL print_gdal_message(CPLErr severity, CPLErrorNum number,
                                    const char* message) noexcept {
    end_program_if_fatal(severity, message);
    CPLDefaultErrorHandler(severity, number, message);
}

void end_program_if_fatal(CPLErr severity, const char* message) noexcept {
    if (severity == CE_Fatal)
        util::end_program("GDAL cannot go on", message != nullptr ? message : "no reason given");
}

}  // namespace terravox::geo
