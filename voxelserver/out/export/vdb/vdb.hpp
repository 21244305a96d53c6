#pragma once

#include "voxelserver/out/export/core/format.hpp"
#include "voxelserver/out/export/core/job.hpp"

namespace terravox::exports {

struct VdbOptions {
    UpAxis up = UpAxis::kZ;
};

/// Writes OpenVDB with three grids: `density` (float) 1 in everything solid, `material` (int32) its
/// material's number, `Cd` (3 floats, linear) the colour of voxels that can be seen. Hidden rock is
/// stored as tiles where possible. Grids are in metres from make_origin(part): the voxel at the
/// part's lowest corner has its middle half a voxel inside. Metadata of the file and of each grid:
/// title, crs, offset, voxel_m, axes, licence, attribution. A part that needs more than
/// memory_bytes is split into several files, NAME_x_z.vdb with the number of their first column of
/// boxes east and south of the part's first; all share one origin, so they fit together. Which
/// columns go together depends on memory_bytes only. The bytes do not depend on the number of
/// threads. The first call loads terravox-vdb.so, and OpenVDB with it (docs/adr/0046).
/// @throws Error when nothing is solid, a file cannot be written, or that module cannot be loaded
void write_vdb(Job& job, const VdbOptions& options = {});

/// The interface of terravox-vdb.so: one function, exported under the name below, that does what
/// write_vdb() promises. Exceptions pass through unchanged: program and module are built together,
/// by one compiler.
/// @param version of the caller: kVersion
/// @throws Error also when the module is of another version
using WriteVdb = void(const char* version, Job& job, const VdbOptions& options);
inline constexpr const char* kWriteVdb = "terravox_write_vdb";
/// Does it, within that module.
void write_vdb_files(Job& job, const VdbOptions& options);

extern const Format kVdbFormat;

}  // namespace terravox::exports
