#pragma once

#include "voxelserver/out/export/core/format.hpp"

namespace terravox::exports {

extern const Format kGlbFormat;
extern const Format kPlyFormat;

}  // namespace terravox::exports
