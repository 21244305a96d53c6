#pragma once

#include "common/util/error.hpp"
#include "voxelserver/serve/server/options.hpp"

namespace terravox::serve {

/// Opens the world and serves it until SIGINT or SIGTERM, or makes all of its boxes
/// (--prepare-only).
/// @return kHoles when boxes could not be prepared
/// @throws Error, UsageError
[[nodiscard]] util::ExitCode serve(Options& options);

}  // namespace terravox::serve
