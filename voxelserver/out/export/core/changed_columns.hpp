#pragma once

#include <span>

#include "voxelserver/out/export/core/format.hpp"
#include "voxelserver/out/export/core/job.hpp"

namespace terravox::exports {

/// What a change of a part replaces and compares.
/// @param changed, others  columns of boxes of the world's level 0
/// @return columns of the part's level; a coarser one that holds columns of both kinds is replaced
[[nodiscard]] ChangedColumns changed_columns(const Part& part, std::span<const ColumnAt> changed,
                                             std::span<const ColumnAt> others);

}  // namespace terravox::exports
