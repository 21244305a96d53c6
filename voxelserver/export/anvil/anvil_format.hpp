#pragma once

#include "voxelserver/export/core/format.hpp"

namespace terravox::exports::anvil {

extern const Format kAnvilFormat;

}  // namespace terravox::exports::anvil
