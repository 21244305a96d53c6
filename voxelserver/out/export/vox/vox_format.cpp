#include "voxelserver/out/export/vox/vox_format.hpp"

#include "voxelserver/out/export/vox/vox.hpp"

namespace terravox::exports {

const Format kVoxFormat{
    .name = "vox",
    .extension = ".vox",
    .check_target = check_file_target,
    .steps = column_steps,
    .write = [](Job& job, const WriteOptions& /*options*/) { write_vox(job); },
};

}  // namespace terravox::exports
