#include "voxelserver/export/archive/archive_format.hpp"

#include "voxelserver/export/archive/archive_export.hpp"

namespace terravox::exports {

const Format kArchiveFormat{
    .name = "archive",
    .extension = ".tvx",
    .check_target = check_file_target,
    .steps = archive_steps,
    .write = [](Job& job, const WriteOptions& options) { write_archive(job, options.shard); },
    .has_shards = true,
};

}  // namespace terravox::exports
