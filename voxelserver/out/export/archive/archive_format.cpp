#include "voxelserver/out/export/archive/archive_format.hpp"

#include "voxelserver/out/export/archive/archive_export.hpp"
#include "voxelserver/out/export/archive/change_export.hpp"

namespace terravox::exports {

namespace {

void write(Job& job, const WriteOptions& options) {
    if (options.changed.replaced.empty())
        write_archive(job, options.shard);
    else
        write_change(job, options.changed);
}

}  // namespace

const Format kArchiveFormat{
    .name = "archive",
    .extension = ".tvx",
    .check_target = check_file_target,
    .steps = archive_steps,
    .write = write,
    .has_shards = true,
};

}  // namespace terravox::exports
