#pragma once

#include <string>

#include "common/util/error.hpp"
#include "raytracer/farm/render/statistics.hpp"

namespace CLI {
class App;
}

namespace terravox::commands {

/// How much a command says while it runs and at its end. Only one of them is set.
struct Verbosity {
    bool quiet = false;    ///< errors only
    bool verbose = false;  ///< what the run cost, too
};

/// Adds the flags --quiet and --verbose to a command. `args` must outlive the parsing.
void add_verbosity_flags(CLI::App& command, Verbosity& args);

/// Tells what a picture or raster lacks: boxes, tiles, damaged parts of the data.
/// @param what it is, for messages: "picture"
/// @return kHoles where it lacks something, else kDone
[[nodiscard]] util::ExitCode report_gaps(const render::RenderStatistics& statistics,
                                         const std::string& what);

}  // namespace terravox::commands
