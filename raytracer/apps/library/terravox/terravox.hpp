#pragma once

#include <terravox/control.hpp>
#include <terravox/error.hpp>
#include <terravox/grids.hpp>
#include <terravox/materials.hpp>
#include <terravox/picture.hpp>
#include <terravox/place.hpp>
#include <terravox/rays.hpp>
#include <terravox/server.hpp>
#include <terravox/sources.hpp>
#include <terravox/survey.hpp>
#include <terravox/world.hpp>

#include <string>

namespace terravox {

/// "0.1.0"
[[nodiscard]] TERRAVOX_API std::string version();

/// What the library writes to standard error: trace, debug, info, warn (the default), error or off.
/// @throws UsageError
TERRAVOX_API void set_log_level(const std::string& level);

}  // namespace terravox
