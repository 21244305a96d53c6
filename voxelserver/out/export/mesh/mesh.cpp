#include "voxelserver/out/export/mesh/mesh.hpp"

#include <algorithm>

#include "common/thread/in_order.hpp"
#include "common/util/atomic_file.hpp"
#include "common/util/error.hpp"
#include "voxelserver/out/export/core/columns.hpp"
#include "voxelserver/out/export/mesh/mesh_writer.hpp"
#include "voxelserver/out/export/shape/placing.hpp"

namespace terravox::exports {
namespace {

// Columns in squares: with a few boxes of each in memory, only those along the edges of a square
// are requested twice.
constexpr std::size_t kSquareEdge = 8;
// One thread holds two columns at once, of some 16 MiB each where it is steep and wooded; half of
// the memory is for that.
constexpr std::size_t kBytesOfThread = std::size_t{32} << 20;

}  // namespace

void write_mesh(Job& job, MeshFormat format, const MeshOptions& options) {
    if (options.colour_steps != 0 && (options.colour_steps < 2 || options.colour_steps > 255))
        throw util::UsageError("write " + job.out.string() +
                               ": colour steps = " + std::to_string(options.colour_steps) +
                               "; allowed: 2 to 255, or 0 for all");
    util::AtomicFile file(job.out);
    const auto writer =
        format == MeshFormat::kGlb ? make_glb_writer(job, options) : make_ply_writer(job);
    ColumnMesher mesher(job, options);
    const Columns columns = job.columns(kSquareEdge);
    const auto max_threads = static_cast<int>(std::max<std::size_t>(
        1, std::min<std::size_t>(1024, job.memory_bytes / 2 / kBytesOfThread)));
    thread::in_order(
        columns.count(), std::min(thread::thread_count(job.threads), max_threads),
        [&](std::size_t i) {
            const auto at = columns.at(i);
            return mesher.make(at.bx, at.bz);
        },
        [&](std::size_t, const ColumnMesh& mesh) {
            writer->add(mesh);
            job.count_voxels(mesh.seen_voxels);
            job.meter.add();
        });
    if (writer->empty())
        fail_for_nothing(job);
    ByteFile out(file.temporary_path(), job.out.string());
    writer->finish(out);
    out.close();
    finish_file(job, file);
}

}  // namespace terravox::exports
