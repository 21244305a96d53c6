#pragma once

#include "voxelserver/out/export/core/format.hpp"

namespace terravox::exports {

extern const Format kVoxFormat;

}  // namespace terravox::exports
