#pragma once

#include <string>

#include "voxelserver/serve/opening_world.hpp"
#include "voxelserver/serve/options.hpp"

namespace terravox::serve {

/// Tells a person, on standard output, what is served and what the server will do.
void announce(const OpeningWorld& world, const Options& options, const Plan& plan,
              const std::string& url);

}  // namespace terravox::serve
