#include "voxelserver/export/archive/archive_export.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <limits>
#include <map>
#include <memory>
#include <set>

#include "common/thread/in_order.hpp"
#include "common/util/atomic_file.hpp"
#include "common/util/error.hpp"
#include "common/util/log.hpp"
#include "common/voxel/archive/archive_writer.hpp"
#include "common/voxel/box_builder.hpp"
#include "common/voxel/box_codec.hpp"
#include "common/voxel/downsample.hpp"
#include "common/voxel/pyramid_world.hpp"
#include "voxelserver/export/core/journal.hpp"

namespace terravox::exports {
namespace {

using voxel::Box;
using voxel::BoxKey;
using voxel::BoxRange;
using voxel::archive::Entry;
using voxel::archive::Kind;

constexpr int kZstdLevel = 9;  // written once, read often

voxel::WorldInfo info_of(const Part& part, const voxel::WorldInfo& world) {
    const auto scale = static_cast<double>(std::int64_t{1} << part.level);
    voxel::WorldInfo info = world;
    info.bounds = part.bounds;
    info.voxel_m *= scale;
    info.crs_units_per_voxel *= scale;
    info.levels = voxel::levels_for(info.bounds);
    info.framed = {};
    return info;
}

// Where the part ends before the world does, a box may extend beyond it.
voxel::VoxelBounds limits_of(const Part& part, const voxel::WorldInfo& world) {
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
            self(self, cells[cell.index_of(std::countr_zero(left))], child_voxels / 64);
    };
    for (int root = 0; root < Box::kRootCount; ++root)
        walk(walk, cells[static_cast<std::size_t>(root)], 4096);
    return count;
}

struct Record {
    BoxKey key;
    Kind kind;
    std::vector<std::byte> frame;
};

Record hole_record(const BoxKey& key, const std::string& why) {
    const auto bytes = std::as_bytes(std::span(why));
    return {key, Kind::kHole, {bytes.begin(), bytes.end()}};
}

// A box, or the reason why there is none.
struct Made {
    std::shared_ptr<const Box> box;
    std::string hole;
};

Made parent_of(const BoxKey& key, const std::array<Made, 8>& children) {
    std::array<std::shared_ptr<const Box>, 8> boxes;
    for (std::size_t i = 0; i < 8; ++i) {
        if (!children[i].hole.empty())
            return {nullptr, children[i].hole};
        boxes[i] = children[i].box;
    }
    return {voxel::downsample(key, boxes), {}};
}

BoxKey child_of(const BoxKey& key, int i) {
    return {key.level - 1, 2 * key.bx + (i & 1), 2 * key.by + (i >> 2), 2 * key.bz + (i >> 1 & 1)};
}

// Makes the boxes under one of level kSubtreeLevel (or of the top, where the world is small),
// itself included; coarse ones first, those of a level in the order of their parents.
class Subtree {
public:
    Subtree(Job& job, const voxel::WorldInfo& info)
        : m_job(job), m_info(info), m_limits(limits_of(job.part, job.world())) {}
    void make(const BoxKey& top) {
        (void)made(top);
        // Whoever reads over a network shows coarse boxes first: those lie together.
        std::stable_sort(records.begin(), records.end(), [](const Record& a, const Record& b) {
            return a.key.level > b.key.level;
        });
    }
    std::vector<Record> records;
    std::uint64_t voxels = 0;

private:
    Made made(const BoxKey& key) {
        if (!voxel::boxes_over(m_info.bounds, key.level).contains(key))
            return {};
        Made out = key.level == 0 ? finest(key) : coarser(key);
        if (!out.hole.empty())
            records.push_back(hole_record(key, out.hole));
        else if (out.box)
            records.push_back({key, Kind::kBox, voxel::compress(*out.box, kZstdLevel)});
        return out;
    }

    Made coarser(const BoxKey& key) {
        std::array<Made, 8> children;
        for (int i = 0; i < 8; ++i)
            children[static_cast<std::size_t>(i)] = made(child_of(key, i));
        return parent_of(key, children);
    }

    Made finest(const BoxKey& key) {
        const voxel::BoxOutcome got = m_job.outcome(key.bx, key.by, key.bz);
        if (got.failure) {
            try {
                std::rethrow_exception(got.failure);
            } catch (const std::exception& e) {
                return {nullptr, e.what()};
            }
        }
        const auto box = got.box ? cut(got.box, m_limits) : nullptr;
        if (!box)
            return {};
        voxels += solid_count(*box);
        return {m_job.part.level == 0 ? box : Box::from_arrays(key, box->cells(), box->attrs()),
                {}};
    }

    Job& m_job;
    const voxel::WorldInfo& m_info;
    const voxel::VoxelBounds m_limits;
};

class Exporter {
public:
    explicit Exporter(Job& job)
        : m_job(job),
          m_info(info_of(job.part, job.world())),
          m_tops(voxel::boxes_over(m_info.bounds, std::min(kSubtreeLevel, m_info.levels - 1))),
          m_columns(columns_of(job, m_tops)),
          m_journal(journal_of(job.out), job.name) {}

    void run() {
        open();
        subtrees();
        for (int level = std::min(kSubtreeLevel, m_info.levels - 1) + 1; level < m_info.levels;
             ++level)
            level_above(level);
        m_writer->finish(m_job.damage());
        m_journal.remove();
        m_job.wrote(m_job.out);
    }

private:
    static std::filesystem::path journal_of(std::filesystem::path out) {
        util::check_writable(out);
        out += ".journal";
        return out;
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

    /// The columns of the tops of subtrees.
    static Columns columns_of(Job& job, const BoxRange& tops) {
        return {block_of(tops), 1, [&](const ColumnBlock& some) {
                    const auto finest = [&](std::int32_t b) { return b << tops.min.level; };
                    return job.may_hold({finest(some.min_bx), finest(some.min_bz),
                                         finest(some.max_bx), finest(some.max_bz)});
                }};
    }

    void subtrees() {
        const auto ny = static_cast<std::size_t>(m_tops.max.by - m_tops.min.by);
        m_job.meter.add(m_columns.left_out() * ny);
        const auto key_at = [&](std::size_t i) {
            const Columns::At at = m_columns.at(i / ny);
            return BoxKey{m_tops.min.level, at.bx,
                          m_tops.min.by + static_cast<std::int32_t>(i % ny), at.bz};
        };
        thread::in_order(
            m_columns.count() * ny, m_job.threads,
            [&](std::size_t i) {
                Subtree made(m_job, m_info);
                if (!m_journal.has(voxel::to_string(key_at(i))))
                    made.make(key_at(i));
                return made;
            },
            [&](std::size_t i, Subtree made) {
                const std::string name = voxel::to_string(key_at(i));
                if (!m_journal.has(name)) {
                    for (const Record& r : made.records)
                        m_writer->add(r.key, r.kind, r.frame);
                    const bool whole =
                        std::none_of(made.records.begin(), made.records.end(),
                                     [](const Record& r) { return r.kind == Kind::kHole; });
                    m_whole = m_whole && whole;
                    // With a hole, the next run retries from here on.
                    if (m_whole)
                        m_journal.add(name, made.voxels, m_writer->flush());
                    m_job.count_voxels(made.voxels);
                }
                m_job.meter.add();
            });
    }

    Made read_back(const BoxKey& key, const Entry& entry) {
        const auto frame = m_writer->frame_of(entry);
        if (entry.kind == Kind::kHole)
            return {nullptr,
                    std::string(reinterpret_cast<const char*>(frame.data()), frame.size())};
        return {voxel::decompress_box(frame, voxel::to_string(key)), {}};
    }

    void level_above(int level) {
        m_writer->flush();
        std::map<BoxKey, Entry> below;
        std::set<BoxKey> parents;
        for (const Entry& e : m_writer->entries()) {
            const BoxKey key = voxel::archive::key_of(e.key);
            if (key.level != level - 1)
                continue;
            below.emplace(key, e);
            parents.insert({level, voxel::floor_div(key.bx, 2), voxel::floor_div(key.by, 2),
                            voxel::floor_div(key.bz, 2)});
        }
        const std::vector<BoxKey> keys(parents.begin(), parents.end());
        thread::in_order(
            keys.size(), m_job.threads,
            [&](std::size_t i) {
                std::array<Made, 8> children;
                for (int c = 0; c < 8; ++c) {
                    const BoxKey key = child_of(keys[i], c);
                    if (const auto found = below.find(key); found != below.end())
                        children[static_cast<std::size_t>(c)] = read_back(key, found->second);
                }
                Made made = parent_of(keys[i], children);
                if (!made.hole.empty())
                    return hole_record(keys[i], made.hole);
                return Record{
                    keys[i], Kind::kBox,
                    made.box ? voxel::compress(*made.box, kZstdLevel) : std::vector<std::byte>{}};
            },
            [&](std::size_t, const Record& r) {
                if (!r.frame.empty())
                    m_writer->add(r.key, r.kind, r.frame);
            });
    }

    Job& m_job;
    const voxel::WorldInfo m_info;
    const BoxRange m_tops;    ///< of subtrees
    const Columns m_columns;  ///< before the journal: a rejected export leaves nothing
    Journal m_journal;
    std::unique_ptr<voxel::ArchiveWriter> m_writer;
    bool m_whole = true;
};

}  // namespace

std::uint64_t archive_steps(const Part& part, const voxel::WorldInfo& world) {
    const voxel::WorldInfo info = info_of(part, world);
    const BoxRange r = voxel::boxes_over(info.bounds, std::min(kSubtreeLevel, info.levels - 1));
    return static_cast<std::uint64_t>(r.max.bx - r.min.bx) *
           static_cast<std::uint64_t>(r.max.by - r.min.by) *
           static_cast<std::uint64_t>(r.max.bz - r.min.bz);
}

void write_archive(Job& job) {
    Exporter(job).run();
}

}  // namespace terravox::exports
