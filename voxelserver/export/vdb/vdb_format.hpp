#pragma once

#include "voxelserver/export/core/format.hpp"

namespace terravox::exports {

extern const Format kVdbFormat;

}  // namespace terravox::exports
