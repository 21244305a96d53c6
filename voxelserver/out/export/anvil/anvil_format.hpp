#pragma once

#include "voxelserver/out/export/core/format.hpp"

namespace terravox::exports::anvil {

extern const Format kAnvilFormat;

}  // namespace terravox::exports::anvil
