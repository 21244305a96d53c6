#pragma once

#include "voxelserver/export/core/format.hpp"

namespace terravox::exports {

extern const Format kVoxFormat;

}  // namespace terravox::exports
