#include "voxelserver/out/export/archive/change_export.hpp"

#include <vector>

#include "common/thread/in_order.hpp"
#include "common/voxel/archive/archive_writer.hpp"
#include "common/voxel/archive/change.hpp"
#include "common/voxel/archive/unfinished.hpp"
#include "voxelserver/out/export/archive/archive_box.hpp"

namespace terravox::exports {
namespace {

using voxel::archive::ColumnRun;
using voxel::archive::ColumnSet;
using voxel::archive::MadeRecord;

ColumnSet set_of(const std::vector<ColumnAt>& columns) {
    std::vector<ColumnRun> runs;
    for (const ColumnAt& at : columns)
        runs.push_back({at.bz, at.bx, at.bx + 1});
    return ColumnSet(std::move(runs));
}

struct MadeOfColumn {
    std::vector<MadeRecord> records;
    std::uint64_t voxels = 0;
};

MadeOfColumn make_column(Job& job, const voxel::WorldInfo& info, const ColumnAt& at) {
    const voxel::BoxRange all = voxel::boxes_over(info.bounds, 0);
    const voxel::VoxelBounds limits = archive_limits(job.part, job.world());
    MadeOfColumn out;
    for (std::int32_t by = all.min.by; by < all.max.by; ++by) {
        const voxel::BoxKey key{0, at.bx, by, at.bz};
        const ArchiveBox box = archive_box(job, limits, key);
        out.voxels += box.voxels;
        if (MadeRecord record = voxel::archive::record_of(key, box.made); !record.frame.empty())
            out.records.push_back(std::move(record));
    }
    return out;
}

}  // namespace

void write_change(Job& job, const ChangedColumns& columns) {
    const voxel::WorldInfo info = archive_info(job.part, job.world());
    std::vector<ColumnAt> all = columns.replaced;
    all.insert(all.end(), columns.compared.begin(), columns.compared.end());
    voxel::ArchiveWriter writer(job.out, info, 0);
    // There is no journal by which another run could go on.
    voxel::archive::Unfinished unfinished(writer);
    thread::in_order(
        all.size(), job.threads, [&](std::size_t i) { return make_column(job, info, all[i]); },
        [&](std::size_t, const MadeOfColumn& made) {
            for (const MadeRecord& record : made.records)
                writer.add(record.key, record.kind, record.frame);
            job.count_voxels(made.voxels);
            job.meter.add();
        });
    writer.finish_change(voxel::archive::json_of(voxel::archive::Change{
        set_of(columns.replaced), set_of(columns.compared), job.damage_lines()}));
    unfinished.release();
    job.wrote(job.out);
}

}  // namespace terravox::exports
