#pragma once

#include "voxelserver/out/export/core/format.hpp"
#include "voxelserver/out/export/core/job.hpp"

namespace terravox::exports {

/// Writes a change of a box archive (common/voxel/archive/change.hpp): the boxes of some columns,
/// without coarse levels, which patching makes. A run that ends early leaves nothing under the
/// change's name. The bytes do not depend on threads.
/// @param columns within the part, of its level; not empty
void write_change(Job& job, const ChangedColumns& columns);

}  // namespace terravox::exports
