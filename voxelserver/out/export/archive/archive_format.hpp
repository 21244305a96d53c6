#pragma once

#include "voxelserver/out/export/core/format.hpp"

namespace terravox::exports {

extern const Format kArchiveFormat;

}  // namespace terravox::exports
