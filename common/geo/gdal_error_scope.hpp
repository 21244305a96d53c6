#pragma once

#include <cpl_error.h>

#include <algorithm>
#include <string>

#include "common/geo/gdal_messages.hpp"

namespace terravox::geo {

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
