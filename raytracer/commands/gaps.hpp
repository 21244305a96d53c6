#pragma once

#include <string>

#include "common/util/error.hpp"
#include "raytracer/render/statistics.hpp"

namespace terravox::commands {

/// Tells what a picture or raster lacks: boxes, tiles, damaged parts of the data.
/// @param what it is, for messages: "picture"
/// @return kHoles where it lacks something, else kDone
[[nodiscard]] util::ExitCode report_gaps(const render::RenderStatistics& statistics,
                                         const std::string& what);

}  // namespace terravox::commands
