#include "voxelserver/out/archive/open_changes.hpp"

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>

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
            file.each_entry([&](const Entry& entry) {
                const BoxKey key = voxel::archive::key_of(entry.key);
                if (key.level == 0 && (columns == nullptr || columns->touches(key)) &&
                    source_of(key) == &file)
                    ++out;
            });
        };
        add(m_archive);
        for (const OpenChange& other : m_changes)
            add(other.file);
        return out;
    }
    [[nodiscard]] std::optional<SourcedRecord> find(const BoxKey& key) const {
        const IndexedFile* const file = source_of(key);
        const auto entry = file == nullptr ? std::nullopt : file->find(key);
        if (!entry)
            return std::nullopt;
        return SourcedRecord{file, *entry};
    }

private:
    /// @return nullptr: the archive has air there, or what is of the change
    [[nodiscard]] const IndexedFile* source_of(const BoxKey& key) const {
        if (!m_replaced.touches(key))
            return &m_archive;
        if (m_change.facts.replaced.touches(key))
            return nullptr;
        const OpenChange* const change = change_of(m_changes, key);
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
    change.file.each_entry([&](const Entry& entry) {
        const BoxKey key = voxel::archive::key_of(entry.key);
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

const OpenChange* change_of(std::span<const OpenChange> changes, const BoxKey& key) {
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

}  // namespace terravox::archive_tools
