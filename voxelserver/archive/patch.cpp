#include "voxelserver/archive/patch.hpp"

#include <algorithm>
#include <atomic>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "common/thread/in_order.hpp"
#include "common/util/error.hpp"
#include "common/voxel/archive/change.hpp"
#include "common/voxel/archive/coarse_levels.hpp"
#include "common/voxel/archive/unfinished.hpp"
#include "voxelserver/archive/indexed_file.hpp"
#include "voxelserver/archive/open_changes.hpp"
#include "voxelserver/archive/records.hpp"

namespace terravox::archive_tools {
namespace {

using voxel::BoxKey;
using voxel::archive::ArchiveIndex;
using voxel::archive::ColumnRun;
using voxel::archive::Entry;
using voxel::archive::Kind;
using voxel::archive::kSubtreeLevel;
using voxel::archive::MadeBox;
using voxel::archive::MadeRecord;

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
                                             const Entry* const there =
                                                 is_new(key) ? nullptr : m_old->find(key);
                                             if (there == nullptr)
                                                 return std::nullopt;
                                             ++kept;
                                             return m_old->record(*there);
                                         });
        m_report.kept += kept;
        std::uint64_t old_holes = 0;
        for (const Entry& entry : writer.entries()) {
            m_report.holes += entry.kind == Kind::kHole ? 1 : 0;
            old_holes += entry.kind == Kind::kHole && entry.key.level == 0 &&
                                 !m_replaced.touches(voxel::archive::key_of(entry.key))
                             ? 1
                             : 0;
        }
        m_report.made = writer.entries().size() - m_report.kept;
        writer.finish(damage(old_holes > 0));
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
        std::set<std::tuple<std::int32_t, std::int32_t, std::int32_t>> places;
        const auto add = [&](const Entry& entry) {
            if (entry.key.level > top_level())
                return;
            const int up = top_level() - entry.key.level;
            places.emplace(entry.key.bz >> up, entry.key.bx >> up, entry.key.by >> up);
        };
        for (const Entry& entry : m_old->entries())
            add(entry);
        for (const OpenChange& change : m_changes)
            for (const Entry& entry : change.file.entries())
                add(entry);
        std::vector<BoxKey> out;
        for (const auto& [bz, bx, by] : places)
            out.push_back({top_level(), bx, by, bz});
        return out;
    }

    void add_subtrees(voxel::ArchiveWriter& writer, int threads,
                      const std::function<void(std::uint64_t, std::uint64_t)>& progress) {
        const std::vector<BoxKey> all = tops();
        thread::in_order(
            all.size(), threads, [&](std::size_t i) { return subtree(all[i]); },
            [&](std::size_t i, const PatchedSubtree& made) {
                for (const MadeRecord& record : made.records)
                    writer.add(record.key, record.kind, record.frame);
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
                    {voxel::archive::key_of(record.old.key), record.old.kind, std::move(*frame++)});
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
        std::array<MadeBox, 8> children;
        if (key.level > 0)
            for (int i = 0; i < 8; ++i)
                children[static_cast<std::size_t>(i)] =
                    place(voxel::archive::child_of(key, i), is_made, out);
        if (!is_made) {
            const Entry* const there = m_old->find(key);
            if (there == nullptr)
                return {};
            out.push_back({*there, {}, true});
            return wanted ? m_old->box(*there) : MadeBox{};
        }
        if (key.level == 0) {
            const auto [change, entry] = changed_entry(m_changes, key);
            if (entry == nullptr)
                return {};
            out.push_back({{}, change->file.record(*entry), false});
            return change->file.box(*entry);
        }
        MadeBox made = voxel::archive::coarse_box(key, children);
        if (MadeRecord record = voxel::archive::record_of(key, made); !record.frame.empty())
            out.push_back({{}, std::move(record), false});
        return made;
    }

    /// Whether a box may be other than in the old archive, or is of a level that it has not.
    [[nodiscard]] bool is_new(const BoxKey& key) const {
        return m_replaced.touches(key) || key.level >= m_old->index().info().levels;
    }

    [[nodiscard]] std::size_t damage(bool has_old_holes) const {
        std::set<std::string> lines;
        for (const OpenChange& change : m_changes)
            lines.insert(change.facts.damage.begin(), change.facts.damage.end());
        return lines.size() + (has_old_holes ? m_old->index().header().damage : 0);
    }

    std::optional<IndexedFile> m_old;  ///< opened once the new one is locked
    std::vector<OpenChange> m_changes;
    voxel::archive::ColumnSet m_replaced;
    PatchReport m_report;
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
