#pragma once

#include "voxelserver/out/export/core/job.hpp"
#include "voxelserver/out/export/vdb/vdb.hpp"

namespace terravox::exports {

/// The interface of terravox-vdb.so: one function, exported under the name below, that does what
/// write_vdb() promises. Exceptions pass through unchanged: program and module are built together,
/// by one compiler.
/// @param version of the caller: kVersion
/// @throws Error also when the module is of another version
using WriteVdb = void(const char* version, Job& job, const VdbOptions& options);
inline constexpr const char* kWriteVdb = "terravox_write_vdb";

}  // namespace terravox::exports
