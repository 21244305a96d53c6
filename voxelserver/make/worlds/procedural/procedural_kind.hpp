#pragma once

#include "voxelserver/make/worlds/kind/world_kind.hpp"

namespace terravox::worlds {

/// A world of noise: the input is the text "generated" or "generated:SEED".
extern const WorldKind kProceduralKind;

}  // namespace terravox::worlds
