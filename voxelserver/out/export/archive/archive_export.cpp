#include "voxelserver/out/export/archive/archive_export.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <memory>
#include <system_error>
#include <utility>
#include <vector>

#include "common/thread/in_order.hpp"
#include "common/util/atomic_file.hpp"
#include "common/util/error.hpp"
#include "common/util/log.hpp"
#include "common/voxel/archive/archive_parts.hpp"
#include "common/voxel/archive/archive_writer.hpp"
#include "common/voxel/archive/coarse_levels.hpp"
#include "common/voxel/box_builder.hpp"
#include "common/voxel/pyramid_world.hpp"
#include "voxelserver/out/export/core/journal.hpp"

namespace terravox::exports {
namespace {

using voxel::Box;
using voxel::BoxKey;

// The box without the voxels outside the limits.
std::shared_ptr<const Box> cut(const std::shared_ptr<const Box>& box,
                               const voxel::VoxelBounds& limits) {
    const std::array<std::int32_t, 3> size{voxel::kBoxSizeX, voxel::kBoxSizeY, voxel::kBoxSizeZ};
    const std::array<std::int32_t, 3> at{box->key().bx * size[0], box->key().by * size[1],
                                         box->key().bz * size[2]};
    std::array<int, 3> low{};
    std::array<int, 3> high{};
    bool whole = true;
    for (std::size_t a = 0; a < 3; ++a) {
        low[a] = std::clamp(limits.min[a] - at[a], 0, size[a]);
        high[a] = std::clamp(limits.max[a] - at[a], 0, size[a]);
        whole = whole && low[a] == 0 && high[a] == size[a];
    }
    if (whole)
        return box;
    voxel::BoxBuilder builder;
    for (int x = low[0]; x < high[0]; ++x)
        for (int z = low[2]; z < high[2]; ++z)
            for (int y = low[1]; y < high[1]; ++y)
                if (const auto voxel = box->voxel(x, y, z))
                    builder.add(x, z, y, y + 1, !voxel::see_through(voxel->material));
    return builder.build(box->key(), [&](int x, int y, int z) { return *box->voxel(x, y, z); });
}

std::uint64_t solid_count(const Box& box) {
    const auto cells = box.cells();
    std::uint64_t count = 0;
    const auto walk = [&](const auto& self, const voxel::TreeCell& cell,
                          std::uint64_t child_voxels) -> void {
        if (child_voxels == 1) {
            count += static_cast<std::uint64_t>(std::popcount(cell.mask));
            return;
        }
        count += static_cast<std::uint64_t>(std::popcount(cell.mask & ~cell.detail)) * child_voxels;
        for (std::uint64_t left = cell.detail; left != 0; left &= left - 1)
            self(self, cells[cell.compute_index(std::countr_zero(left))], child_voxels / 64);
    };
    for (int root = 0; root < Box::kRootCount; ++root)
        walk(walk, cells[static_cast<std::size_t>(root)], 4096);
    return count;
}

}  // namespace

voxel::WorldInfo archive_info(const Part& part, const voxel::WorldInfo& world) {
    const auto scale = static_cast<double>(std::int64_t{1} << part.level);
    voxel::WorldInfo info = world;
    info.bounds = part.bounds;
    info.voxel_m *= scale;
    info.crs_units_per_voxel *= scale;
    info.levels = voxel::levels_for(info.bounds);
    info.framed = {};
    if (info.typical_heights) {
        info.typical_heights->min >>= part.level;
        info.typical_heights->max = ((info.typical_heights->max - 1) >> part.level) + 1;
    }
    return info;
}

voxel::VoxelBounds archive_limits(const Part& part, const voxel::WorldInfo& world) {
    constexpr std::int32_t kFar = 1 << 30;
    voxel::VoxelBounds limits = part.bounds;
    for (std::size_t a = 0; a < 3; ++a) {
        if (part.bounds.min[a] <= world.bounds.min[a] >> part.level)
            limits.min[a] = -kFar;
        if (part.bounds.max[a] > (world.bounds.max[a] - 1) >> part.level)
            limits.max[a] = kFar;
    }
    return limits;
}

ArchiveBox archive_box(Job& job, const voxel::VoxelBounds& limits, const BoxKey& key) {
    const voxel::BoxOutcome got = job.outcome(key.bx, key.by, key.bz);
    if (got.failure) {
        try {
            std::rethrow_exception(got.failure);
        } catch (const std::exception& e) {
            return {{nullptr, e.what()}, 0};
        }
    }
    const auto box = got.box ? cut(got.box, limits) : nullptr;
    if (!box)
        return {};
    const auto as_finest =
        job.part.level == 0 ? box : Box::from_arrays(key, box->cells(), box->attrs());
    return {{as_finest, std::nullopt}, solid_count(*box)};
}

namespace {

using voxel::BoxRange;
using voxel::archive::Kind;
using voxel::archive::kSubtreeLevel;
using voxel::archive::MadeBox;
using voxel::archive::MadeRecord;

// Makes the boxes under one of level kSubtreeLevel (or of the top, where the world is small),
// itself included; coarse ones first, those of a level in the order of their parents.
class Subtree {
public:
    Subtree(Job& job, const voxel::WorldInfo& info)
        : m_job(job), m_info(info), m_limits(archive_limits(job.part, job.world())) {}
    void make(const BoxKey& top) {
        (void)made(top);
        // Whoever reads over a network shows coarse boxes first: those lie together.
        std::stable_sort(
            records.begin(), records.end(),
            [](const MadeRecord& a, const MadeRecord& b) { return a.key.level > b.key.level; });
    }
    std::vector<MadeRecord> records;
    std::uint64_t voxels = 0;

private:
    MadeBox made(const BoxKey& key) {
        if (!voxel::boxes_over(m_info.bounds, key.level).contains(key))
            return {};
        MadeBox out = key.level == 0 ? finest(key) : coarser(key);
        if (out.box || out.hole)
            records.push_back(voxel::archive::make_record(key, out));
        return out;
    }

    MadeBox coarser(const BoxKey& key) {
        const auto child = [this](const BoxKey& below) { return made(below); };
        return voxel::archive::coarse_box(key, voxel::Pyramid::children(key, child));
    }

    MadeBox finest(const BoxKey& key) {
        ArchiveBox out = archive_box(m_job, m_limits, key);
        voxels += out.voxels;
        return out.made;
    }

    Job& m_job;
    const voxel::WorldInfo& m_info;
    const voxel::VoxelBounds m_limits;
};

static_assert(ShardChoice::kMost == voxel::archive::kMaxShards);

/// The boxes at the tops of subtrees.
BoxRange find_tops(const voxel::WorldInfo& info) {
    return voxel::boxes_over(info.bounds, std::min(kSubtreeLevel, info.levels - 1));
}

/// The columns of the tops of subtrees.
Columns find_columns(Job& job, const BoxRange& tops) {
    return {to_block(tops), 1, [&](const ColumnBlock& some) {
                const auto finest = [&](std::int32_t b) { return b << tops.min.level; };
                return job.may_hold({finest(some.min_bx), finest(some.min_bz), finest(some.max_bx),
                                     finest(some.max_bz)});
            }};
}

/// What the name of a conversion ends with.
std::string make_suffix(const ShardChoice& shard) {
    return shard.of == 0
               ? ""
               : " shard " + std::to_string(shard.number) + " of " + std::to_string(shard.of);
}

std::filesystem::path find_journal(std::filesystem::path out) {
    out += ".journal";
    return out;
}

class Exporter {
public:
    Exporter(Job& job, const ShardChoice& shard)
        : m_job(job),
          m_shard(shard),
          m_info(archive_info(job.part, job.world())),
          m_tops(find_tops(m_info)),
          m_columns(find_columns(job, m_tops)),
          m_journal(make_writable_journal(job.out), job.name + make_suffix(shard)) {}

    void run() {
        open();
        subtrees();
        if (m_shard.of > 0) {
            m_writer->finish_shard(voxel::archive::to_json(
                {m_shard.number, m_shard.of, m_job.name, m_job.damage_lines()}));
        } else {
            voxel::archive::add_levels_above(*m_writer, m_tops.min.level, m_info.levels,
                                             m_job.threads);
            m_writer->finish(m_job.damage_lines().size());
        }
        m_journal.remove();
        m_job.wrote(m_job.out);
    }

private:
    static std::filesystem::path make_writable_journal(const std::filesystem::path& out) {
        util::check_writable(out);
        return find_journal(out);
    }

    void open() {
        if (m_journal.end_before() > 0) {
            try {
                m_writer = std::make_unique<voxel::ArchiveWriter>(m_job.out, m_info,
                                                                  m_journal.end_before());
                m_job.count_voxels(m_journal.voxels_before());
                util::log_info("going on with {}.part", m_job.out.string());
                return;
            } catch (const util::Error& e) {
                util::log_warn("{}; beginning anew", e.what());
                m_journal.forget();
            }
        }
        m_writer = std::make_unique<voxel::ArchiveWriter>(m_job.out, m_info, 0);
    }

    void subtrees() {
        const auto ny = static_cast<std::size_t>(m_tops.max.by - m_tops.min.by);
        const auto [first, end] = columns_of_shard(m_shard, m_columns.count());
        m_job.meter.add((m_columns.left_out() + m_columns.count() - (end - first)) * ny);
        const auto key_at = [&, first = first](std::size_t i) {
            const Columns::At at = m_columns.at(first + i / ny);
            return BoxKey{m_tops.min.level, at.bx,
                          m_tops.min.by + static_cast<std::int32_t>(i % ny), at.bz};
        };
        thread::in_order((end - first) * ny, m_job.threads,
                         [&](std::size_t i) {
                             Subtree made(m_job, m_info);
                             if (!m_journal.has(voxel::to_string(key_at(i))))
                                 made.make(key_at(i));
                             return made;
                         },
                         [&](std::size_t i, Subtree made) {
                             const std::string name = voxel::to_string(key_at(i));
                             if (!m_journal.has(name)) {
                                 for (const MadeRecord& r : made.records)
                                     m_writer->add(r.key, r.kind, r.frame);
                                 const bool whole = std::none_of(
                                     made.records.begin(), made.records.end(),
                                     [](const MadeRecord& r) { return r.kind == Kind::kHole; });
                                 m_whole = m_whole && whole;
                                 // With a hole, the next run retries from here on.
                                 if (m_whole)
                                     m_journal.add(name, made.voxels, m_writer->flush());
                                 m_job.count_voxels(made.voxels);
                             }
                             m_job.meter.add();
                         });
    }

    Job& m_job;
    const ShardChoice m_shard;
    const voxel::WorldInfo m_info;
    const BoxRange m_tops;    ///< of subtrees
    const Columns m_columns;  ///< before the journal: a rejected export leaves nothing
    Journal m_journal;
    std::unique_ptr<voxel::ArchiveWriter> m_writer;
    bool m_whole = true;
};

}  // namespace

std::uint64_t archive_steps(const Part& part, const voxel::WorldInfo& world) {
    const BoxRange r = find_tops(archive_info(part, world));
    return static_cast<std::uint64_t>(r.max.bx - r.min.bx) *
           static_cast<std::uint64_t>(r.max.by - r.min.by) *
           static_cast<std::uint64_t>(r.max.bz - r.min.bz);
}

void write_archive(Job& job, const ShardChoice& shard) {
    Exporter(job, shard).run();
}

ArchiveColumns archive_columns(Job& job) {
    const BoxRange tops = find_tops(archive_info(job.part, job.world()));
    return {find_columns(job, tops), voxel::kBoxSizeX << tops.min.level,
            static_cast<std::uint64_t>(tops.max.by - tops.min.by)};
}

std::pair<std::size_t, std::size_t> columns_of_shard(const ShardChoice& shard,
                                                     std::size_t columns) {
    if (shard.of == 0)
        return {0, columns};
    const auto find_end = [&](int number) {
        return columns * static_cast<std::size_t>(number) / static_cast<std::size_t>(shard.of);
    };
    return {find_end(shard.number - 1), find_end(shard.number)};
}

MadeColumn make_archive_column(Job& job, const Columns::At& column) {
    // An entry of the index, packed: a measured mean.
    constexpr std::uint64_t kEntry_bytes = 12;
    const voxel::WorldInfo info = archive_info(job.part, job.world());
    const BoxRange tops = find_tops(info);
    MadeColumn out;
    for (std::int32_t by = tops.min.by; by < tops.max.by; ++by) {
        Subtree subtree(job, info);
        subtree.make({tops.min.level, column.bx, by, column.bz});
        for (const MadeRecord& record : subtree.records) {
            ++out.boxes;
            out.bytes += sizeof(voxel::archive::Record) + record.frame.size() + kEntry_bytes;
        }
    }
    return out;
}

void remove_journal(const std::filesystem::path& out) {
    std::error_code ignored;
    std::filesystem::remove(find_journal(out), ignored);
}

std::size_t finished_subtrees(const std::filesystem::path& out, const std::string& name,
                              const ShardChoice& shard) {
    return Journal::files_in(find_journal(out), name + make_suffix(shard));
}

namespace {

using voxel::archive::ColumnRun;
using voxel::archive::ColumnSet;

ColumnSet make_set(const std::vector<ColumnAt>& columns) {
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
        if (MadeRecord record = voxel::archive::make_record(key, box.made); !record.frame.empty())
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
    writer.finish_change(voxel::archive::to_json(voxel::archive::Change{
        make_set(columns.replaced), make_set(columns.compared), job.damage_lines()}));
    unfinished.release();
    job.wrote(job.out);
}

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
