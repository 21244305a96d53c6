#pragma once

#include "voxelserver/export/core/format.hpp"

namespace terravox::exports {

extern const Format kGlbFormat;
extern const Format kPlyFormat;

}  // namespace terravox::exports
