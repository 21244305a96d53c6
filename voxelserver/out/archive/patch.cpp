#include "voxelserver/out/archive/patch.hpp"

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "common/thread/in_order.hpp"
#include "common/util/error.hpp"
#include "common/voxel/archive/archive_parts.hpp"
#include "common/voxel/archive/archive_writer.hpp"
#include "common/voxel/archive/coarse_levels.hpp"
#include "voxelserver/out/archive/indexed_file.hpp"

namespace terravox::archive_tools {
namespace {

using voxel::BoxKey;
using voxel::archive::ColumnSet;
using voxel::archive::Entry;
using voxel::archive::MadeRecord;

/// Whether boxes of both lie in the same places: what else the facts say may differ.
bool same_frame(const voxel::WorldInfo& a, const voxel::WorldInfo& b) {
    return a.voxel_m == b.voxel_m && a.crs == b.crs && a.crs_wkt == b.crs_wkt &&
           a.crs_units_per_voxel == b.crs_units_per_voxel;
}

/// A record of the patched archive, in the file that it comes from.
struct SourcedRecord {
    const IndexedFile* file = nullptr;
    Entry entry;
};

/// The records that a patched archive has of others than one of its changes, in its finest level.
class OtherRecords {
public:
    OtherRecords(const IndexedFile& archive, std::span<const OpenChange> changes,
                 const ColumnSet& replaced, const OpenChange& change)
        : m_archive(archive), m_changes(changes), m_replaced(replaced), m_change(change) {}

    /// @param columns nullptr: all
    [[nodiscard]] std::uint64_t count(const ColumnSet* columns) const {
        std::uint64_t out = 0;
        const auto add = [&](const IndexedFile& file) {
            file.index().each_entry([&](const Entry& entry) {
                const BoxKey key = voxel::archive::to_key(entry.key);
                if (key.level == 0 && (columns == nullptr || columns->touches(key)) &&
                    find_source(key) == &file)
                    ++out;
            });
        };
        add(m_archive);
        for (const OpenChange& other : m_changes)
            add(other.file);
        return out;
    }
    [[nodiscard]] std::optional<SourcedRecord> find(const BoxKey& key) const {
        const IndexedFile* const file = find_source(key);
        const auto entry = file == nullptr ? std::nullopt : file->find(key);
        if (!entry)
            return std::nullopt;
        return SourcedRecord{file, *entry};
    }

private:
    /// @return nullptr: the archive has air there, or what is of the change
    [[nodiscard]] const IndexedFile* find_source(const BoxKey& key) const {
        if (!m_replaced.touches(key))
            return &m_archive;
        if (m_change.facts.replaced.touches(key))
            return nullptr;
        const OpenChange* const change = find_change(m_changes, key);
        return change == nullptr ? nullptr : &change->file;
    }

    const IndexedFile& m_archive;
    const std::span<const OpenChange> m_changes;
    const ColumnSet& m_replaced;
    const OpenChange& m_change;
};

/// Whether a change has the records of others in the columns that it compares, and no more.
bool are_alike(const OtherRecords& others, const OpenChange& change) {
    std::uint64_t compared = 0;
    bool is_alike = true;
    change.file.index().each_entry([&](const Entry& entry) {
        const BoxKey key = voxel::archive::to_key(entry.key);
        if (!is_alike || !change.facts.compared.touches(key))
            return;
        ++compared;
        const auto other = others.find(key);
        if (!other) {
            is_alike = false;
            return;
        }
        const MadeRecord a = other->file->record(other->entry);
        const MadeRecord b = change.file.record(entry);
        is_alike = a.kind == b.kind && a.frame == b.frame;
    });
    return is_alike && compared == others.count(&change.facts.compared);
}

}  // namespace

OpenChange open_change(const std::filesystem::path& path) {
    IndexedFile file(path, voxel::archive::ArchiveIndex::Of::kAnyFile);
    if (file.index().kind() != voxel::archive::FileKind::kChange)
        throw util::UsageError("patch with " + path.string() +
                               ": not a change; allowed: those of convert --squares");
    voxel::archive::Change facts = voxel::archive::read_change(file.source(), file.index());
    return {std::move(file), std::move(facts)};
}

const OpenChange* find_change(std::span<const OpenChange> changes, const BoxKey& key) {
    const auto found = std::find_if(changes.begin(), changes.end(), [&](const OpenChange& change) {
        return change.facts.replaced.touches(key);
    });
    return found == changes.end() ? nullptr : &*found;
}

void check_worlds(const IndexedFile& archive, std::span<const OpenChange> changes) {
    for (const OpenChange& change : changes) {
        const std::string& name = change.file.source().name();
        if (!same_frame(change.file.index().info(), archive.index().info()))
            throw util::UsageError("patch " + archive.source().name() + " with " + name +
                                   ": it has another CRS or size of voxels; allowed: the same");
        if (change.file.index().info().bounds != changes.front().file.index().info().bounds)
            throw util::UsageError("patch with " + name + ": its world is not that of " +
                                   changes.front().file.source().name() +
                                   "; allowed: changes of one state of the data");
    }
}

void check_compared(const IndexedFile& archive, std::span<const OpenChange> changes,
                    const ColumnSet& replaced) {
    for (const OpenChange& change : changes) {
        const ColumnSet& compared = change.facts.compared;
        const bool compares = compared.count() > 0;
        const OtherRecords others(archive, changes, replaced, change);
        const std::string attempt =
            "patch " + archive.source().name() + " with " + change.file.source().name() + ": ";
        if (!compares && others.count(nullptr) > 0)
            throw util::UsageError(
                attempt +
                "it has no boxes to compare with those that stay; allowed: a change that has, as "
                "convert --squares makes them, or one of all boxes");
        if (compares && !are_alike(others, change))
            throw util::UsageError(
                attempt +
                "boxes that have not changed are not alike; allowed: a change made "
                "with the options of the archive, of data that have not changed elsewhere");
    }
}

namespace {

using voxel::archive::ArchiveIndex;
using voxel::archive::ColumnRun;
using voxel::archive::Kind;
using voxel::archive::kSubtreeLevel;
using voxel::archive::MadeBox;

/// A record of the new archive: a new one, or the place of one in the old archive.
struct Placed {
    Entry old{};
    MadeRecord made;
    bool is_old = false;
    [[nodiscard]] int level() const noexcept { return is_old ? old.key.level : made.key.level; }
};

/// The records under one box, in the order of a conversion, and that of their file.
struct PatchedSubtree {
    std::vector<MadeRecord> records;
    std::uint64_t kept = 0;
};

class Patcher {
public:
    explicit Patcher(std::span<const std::filesystem::path> changes) {
        for (const auto& file : changes)
            m_changes.push_back(open_change(file));
        if (m_changes.empty())
            throw util::UsageError("patch: no change; allowed: those of convert --squares");
    }

    PatchReport write(const std::filesystem::path& archive, const std::filesystem::path& out,
                      int threads,
                      const std::function<void(std::uint64_t, std::uint64_t)>& progress) {
        // The writer holds the lock of its name. What another patch has put there before is read
        // only now, so that none of two patches is lost.
        voxel::ArchiveWriter writer(out, info(), 0);
        voxel::archive::Unfinished unfinished(writer);
        m_old.emplace(archive, ArchiveIndex::Of::kArchive);
        check_worlds(*m_old, m_changes);
        find_replaced();
        check_compared(*m_old, m_changes, m_replaced);
        add_subtrees(writer, threads, progress);
        std::atomic<std::uint64_t> kept{0};
        voxel::archive::add_levels_above(writer, top_level(), info().levels, threads,
                                         [&](const BoxKey& key) -> std::optional<MadeRecord> {
                                             const auto there =
                                                 is_new(key) ? std::nullopt : m_old->find(key);
                                             if (!there)
                                                 return std::nullopt;
                                             ++kept;
                                             return m_old->record(*there);
                                         });
        m_report.kept += kept;
        m_report.holes = writer.holes();
        m_report.made = writer.entries() - m_report.kept;
        writer.finish(damage());
        unfinished.release();
        return m_report;
    }

private:
    [[nodiscard]] const voxel::WorldInfo& info() const {
        return m_changes.front().file.index().info();
    }
    [[nodiscard]] int top_level() const { return std::min(kSubtreeLevel, info().levels - 1); }

    void find_replaced() {
        std::vector<ColumnRun> replaced;
        for (const OpenChange& change : m_changes) {
            const auto runs = change.facts.replaced.runs();
            replaced.insert(replaced.end(), runs.begin(), runs.end());
        }
        m_report.columns = voxel::archive::ColumnSet(replaced).count();
        add_left_out(replaced);
        m_replaced = voxel::archive::ColumnSet(std::move(replaced));
    }

    /// Columns of the old world that lie outside the new one.
    void add_left_out(std::vector<ColumnRun>& out) const {
        const voxel::BoxRange then = voxel::boxes_over(m_old->index().info().bounds, 0);
        const voxel::BoxRange now = voxel::boxes_over(info().bounds, 0);
        for (std::int32_t bz = then.min.bz; bz < then.max.bz; ++bz) {
            if (bz < now.min.bz || bz >= now.max.bz) {
                out.push_back({bz, then.min.bx, then.max.bx});
                continue;
            }
            out.push_back({bz, then.min.bx, std::min(then.max.bx, now.min.bx)});
            out.push_back({bz, std::max(then.min.bx, now.max.bx), then.max.bx});
        }
    }

    /// The boxes at the tops of the subtrees that may hold anything, in the order of a conversion.
    [[nodiscard]] std::vector<BoxKey> tops() const {
        std::vector<BoxKey> out;
        const auto add = [&](const Entry& entry) {
            if (entry.key.level > top_level())
                return;
            const int up = top_level() - entry.key.level;
            const BoxKey top{top_level(), entry.key.bx >> up, entry.key.by >> up,
                             entry.key.bz >> up};
            // Those of a level and a subtree follow each other in the index.
            if (out.empty() || out.back() != top)
                out.push_back(top);
        };
        m_old->index().each_entry(add);
        for (const OpenChange& change : m_changes)
            change.file.index().each_entry(add);
        std::sort(out.begin(), out.end(), [](const BoxKey& a, const BoxKey& b) {
            return std::tie(a.bz, a.bx, a.by) < std::tie(b.bz, b.bx, b.by);
        });
        out.erase(std::unique(out.begin(), out.end()), out.end());
        return out;
    }

    void add_subtrees(voxel::ArchiveWriter& writer, int threads,
                      const std::function<void(std::uint64_t, std::uint64_t)>& progress) {
        const std::vector<BoxKey> all = tops();
        thread::in_order(
            all.size(), threads, [&](std::size_t i) { return subtree(all[i]); },
            [&](std::size_t i, const PatchedSubtree& made) {
                for (const MadeRecord& record : made.records) {
                    writer.add(record.key, record.kind, record.frame);
                    m_has_old_holes |= record.kind == Kind::kHole && record.key.level == 0 &&
                                       !m_replaced.touches(record.key);
                }
                m_report.kept += made.kept;
                if (progress)
                    progress(i + 1, all.size());
            });
    }

    [[nodiscard]] PatchedSubtree subtree(const BoxKey& top) const {
        std::vector<Placed> placed;
        (void)place(top, false, placed);
        // As a conversion writes them: coarse boxes first.
        std::stable_sort(placed.begin(), placed.end(),
                         [](const Placed& a, const Placed& b) { return a.level() > b.level(); });
        std::vector<Entry> old;
        for (const Placed& record : placed)
            if (record.is_old)
                old.push_back(record.old);
        PatchedSubtree out;
        out.kept = old.size();
        std::vector<std::vector<std::byte>> frames;
        read_records(m_old->source(), old, "patch",
                     [&](const Entry&, std::span<const std::byte> frame) {
                         frames.emplace_back(frame.begin(), frame.end());
                     });
        auto frame = frames.begin();
        for (Placed& record : placed) {
            if (record.is_old)
                out.records.push_back(
                    {voxel::archive::to_key(record.old.key), record.old.kind, std::move(*frame++)});
            else
                out.records.push_back(std::move(record.made));
        }
        return out;
    }

    /// Appends the records of a box and of all below it, children first.
    /// @param wanted whether the box is needed for its parent
    /// @return the box; nothing when it is not wanted
    MadeBox place(const BoxKey& key, bool wanted, std::vector<Placed>& out) const {
        if (!voxel::boxes_over(info().bounds, key.level).contains(key))
            return {};
        const bool is_made = is_new(key);
        voxel::Pyramid::Children<MadeBox> children;
        if (key.level > 0)
            children = voxel::Pyramid::children(
                key, [&](const BoxKey& child) { return place(child, is_made, out); });
        if (!is_made) {
            const auto there = m_old->find(key);
            if (!there)
                return {};
            out.push_back({*there, {}, true});
            return wanted ? m_old->box(*there) : MadeBox{};
        }
        if (key.level == 0) {
            const OpenChange* const change = find_change(m_changes, key);
            const auto entry = change == nullptr ? std::nullopt : change->file.find(key);
            if (!entry)
                return {};
            out.push_back({{}, change->file.record(*entry), false});
            return change->file.box(*entry);
        }
        MadeBox made = voxel::archive::coarse_box(key, children);
        if (MadeRecord record = voxel::archive::make_record(key, made); !record.frame.empty())
            out.push_back({{}, std::move(record), false});
        return made;
    }

    /// Whether a box may be other than in the old archive, or is of a level that it has not.
    [[nodiscard]] bool is_new(const BoxKey& key) const {
        return m_replaced.touches(key) || key.level >= m_old->index().info().levels;
    }

    [[nodiscard]] std::size_t damage() const {
        std::set<std::string> lines;
        for (const OpenChange& change : m_changes)
            lines.insert(change.facts.damage.begin(), change.facts.damage.end());
        return lines.size() + (m_has_old_holes ? m_old->index().header().damage : 0);
    }

    std::optional<IndexedFile> m_old;  ///< opened once the new one is locked
    std::vector<OpenChange> m_changes;
    voxel::archive::ColumnSet m_replaced;
    PatchReport m_report;
    bool m_has_old_holes = false;  ///< that the changes do not replace
};

}  // namespace

PatchReport patch(const std::filesystem::path& archive,
                  std::span<const std::filesystem::path> changes, const std::filesystem::path& out,
                  int threads, const std::function<void(std::uint64_t, std::uint64_t)>& progress) {
    for (const auto& change : changes) {
        std::error_code ignored;
        if (std::filesystem::equivalent(change, out, ignored))
            throw util::UsageError("patch to " + out.string() +
                                   ": it is the change; allowed: another name");
    }
    return Patcher(changes).write(archive, out, threads, progress);
}

}  // namespace terravox::archive_tools
