#pragma once

#include <string>

#include "voxelserver/make/worlds/kind/served_world.hpp"
#include "voxelserver/serve/server/options.hpp"

namespace terravox::serve {

/// Prints, on standard output, what is served and what the server will do.
void announce(const worlds::ServedWorld& world, const Options& options, const Plan& plan,
              const std::string& url);

}  // namespace terravox::serve
