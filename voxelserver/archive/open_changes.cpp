#include "voxelserver/archive/open_changes.hpp"

#include <algorithm>
#include <string>
#include <vector>

#include "common/util/error.hpp"

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

/// The records of the patched archive that it does not have from one of its changes, in the order
/// of their keys: those of its finest level in some columns.
/// @param columns nullptr: all
std::vector<SourcedRecord> records_of_others(const IndexedFile& archive,
                                             std::span<const OpenChange> changes,
                                             const ColumnSet& replaced, const OpenChange& change,
                                             const ColumnSet* columns) {
    std::vector<SourcedRecord> out;
    const auto add = [&](const IndexedFile& file, const auto& is_from) {
        for (const Entry& entry : file.entries()) {
            const BoxKey key = voxel::archive::key_of(entry.key);
            if (key.level == 0 && (columns == nullptr || columns->touches(key)) && is_from(key))
                out.push_back({&file, entry});
        }
    };
    add(archive, [&](const BoxKey& key) { return !replaced.touches(key); });
    for (const OpenChange& other : changes)
        add(other.file, [&](const BoxKey& key) {
            return !change.facts.replaced.touches(key) &&
                   changed_entry(changes, key).first == &other;
        });
    std::sort(out.begin(), out.end(), [](const SourcedRecord& a, const SourcedRecord& b) {
        return voxel::archive::before(a.entry.key, b.entry.key);
    });
    return out;
}

/// Whether the records are those that a change has in the columns that it compares.
bool are_alike(std::span<const SourcedRecord> records, const OpenChange& change) {
    std::vector<Entry> compared;
    for (const Entry& entry : change.file.entries())
        if (change.facts.compared.touches(voxel::archive::key_of(entry.key)))
            compared.push_back(entry);
    return std::equal(records.begin(), records.end(), compared.begin(), compared.end(),
                      [&](const SourcedRecord& record, const Entry& entry) {
                          const MadeRecord a = record.file->record(record.entry);
                          const MadeRecord b = change.file.record(entry);
                          return a.key == b.key && a.kind == b.kind && a.frame == b.frame;
                      });
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

std::pair<const OpenChange*, const Entry*> changed_entry(std::span<const OpenChange> changes,
                                                         const BoxKey& key) {
    for (const OpenChange& change : changes)
        if (change.facts.replaced.touches(key))
            return {&change, change.file.find(key)};
    return {nullptr, nullptr};
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
        const auto others =
            records_of_others(archive, changes, replaced, change, compares ? &compared : nullptr);
        const std::string attempt =
            "patch " + archive.source().name() + " with " + change.file.source().name() + ": ";
        if (!compares && !others.empty())
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

}  // namespace terravox::archive_tools
