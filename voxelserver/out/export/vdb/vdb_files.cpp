#include "voxelserver/out/export/vdb/vdb_grids.hpp"

#include <algorithm>
#include <atomic>
#include <optional>

#include "common/thread/in_order.hpp"
#include "common/util/atomic_file.hpp"
#include "common/util/error.hpp"
#include "voxelserver/out/export/shape/placing.hpp"

namespace terravox::exports {
namespace {

// Memory of a column in grids, rounded up: 2 MiB in a wooded town. Where that is too little, blocks
// are halved.
constexpr std::uint64_t kColumnBytes = std::uint64_t{3} << 20;
// While a column is made, the upper nodes of its own trees count, too.
constexpr std::uint64_t kBytesOfThread = std::uint64_t{16} << 20;

/// Writes blocks of columns as files.
class Blocks {
public:
    Blocks(Job& job, const VdbOptions& options)
        : m_job(job), m_frame(job, options.up), m_range(job.part.boxes()) {
        m_whole = to_block(m_range);
        const auto most = static_cast<int>(
            std::clamp<std::uint64_t>(job.memory_bytes / 4 / kBytesOfThread, 1, 1024));
        m_threads = std::min(thread::thread_count(job.threads), most);
    }

    void write_all() {
        // All columns, or squares as large as the memory suffices for.
        const std::uint64_t fit = m_job.memory_bytes / kColumnBytes;
        const auto width = static_cast<std::uint64_t>(m_whole.max_bx - m_whole.min_bx);
        const auto depth = static_cast<std::uint64_t>(m_whole.max_bz - m_whole.min_bz);
        const bool all_fit = width * depth <= fit;
        std::uint64_t edge = all_fit ? std::max(width, depth) : 1;
        while (!all_fit && (edge + 1) * (edge + 1) <= fit)
            ++edge;
        for (const ColumnBlock& block : m_job.columns(edge).squares())
            write(block);
        if (m_files == 0)
            fail_for_nothing(m_job);
    }

private:
    void write(const ColumnBlock& block) {
        const std::int32_t width = block.max_bx - block.min_bx;
        const std::int32_t depth = block.max_bz - block.min_bz;
        if (const auto trees = make(block, width > 1 || depth > 1)) {
            if (!trees->empty()) {
                write_vdb_file(m_job, m_frame, *trees, to_name(block));
                ++m_files;
            }
            m_job.count_voxels(trees->voxels);
            m_job.meter.add(static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(depth));
            return;
        }
        ColumnBlock one = block;
        ColumnBlock other = block;
        if (width >= depth)
            one.max_bx = other.min_bx = block.min_bx + width / 2;
        else
            one.max_bz = other.min_bz = block.min_bz + depth / 2;
        write(one);
        write(other);
    }

    /// @return nullopt when the memory does not suffice, and the block may be divided
    [[nodiscard]] std::optional<VdbTrees> make(const ColumnBlock& block, bool may_fail) {
        const Columns columns(block, 8,
                              [this](const ColumnBlock& part) { return m_job.may_hold(part); });
        VdbTrees all;
        std::uint64_t bytes = 0;
        std::atomic<bool> too_much{false};
        thread::in_order(
            columns.count(), m_threads,
            [&](std::size_t i) {
                const auto at = columns.at(i);
                return too_much ? VdbTrees{} : make_vdb_column(m_job, m_frame, at.bx, at.bz);
            },
            [&](std::size_t, VdbTrees made) {
                if (too_much)
                    return;
                bytes += made.leaf_bytes();
                if (may_fail && bytes > m_job.memory_bytes)
                    too_much = true;
                else
                    all.take(made);
            });
        if (too_much)
            return std::nullopt;
        return all;
    }

    [[nodiscard]] std::filesystem::path to_name(const ColumnBlock& block) const {
        if (block == m_whole)
            return m_job.out;
        const std::string number = "_" + std::to_string(block.min_bx - m_whole.min_bx) + "_" +
                                   std::to_string(block.min_bz - m_whole.min_bz);
        auto out = m_job.out;
        out.replace_filename(m_job.out.stem().string() + number + m_job.out.extension().string());
        return out;
    }

    Job& m_job;
    const VdbFrame m_frame;
    const voxel::BoxRange m_range;
    ColumnBlock m_whole;
    int m_threads = 1;
    std::size_t m_files = 0;
};

}  // namespace

void write_vdb_files(Job& job, const VdbOptions& options) {
    util::check_writable(job.out);
    start_vdb();
    Blocks(job, options).write_all();
}

}  // namespace terravox::exports
