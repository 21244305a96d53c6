#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "common/voxel/archive/archive_index.hpp"
#include "common/voxel/archive/coarse_levels.hpp"

namespace terravox::archive_tools {

/// An archive, or a change of one, whose boxes are looked up. Thread-safe once opened.
class IndexedFile {
public:
    /// @throws Error when it cannot be read
    IndexedFile(const std::filesystem::path& file, voxel::archive::ArchiveIndex::Of of);

    [[nodiscard]] voxel::archive::ByteSource& source() const noexcept { return *m_source; }
    [[nodiscard]] const voxel::archive::ArchiveIndex& index() const noexcept { return *m_index; }
    /// Calls back with each entry, in the order of the index.
    /// @throws Error when the index is damaged
    template <class Visit>
    void each_entry(const Visit& visit) const {
        for (std::size_t leaf = 0; leaf < m_index->leaves().size(); ++leaf)
            for (const voxel::archive::Entry& entry : m_index->entries(leaf))
                visit(entry);
    }
    /// @return nullopt: air
    /// @throws Error when the index is damaged
    [[nodiscard]] std::optional<voxel::archive::Entry> find(const voxel::BoxKey& key) const {
        return m_finder->find(key);
    }
    /// A record as it is in the file.
    /// @throws Error when it is damaged
    [[nodiscard]] voxel::archive::MadeRecord record(const voxel::archive::Entry& entry) const;
    /// A record, unpacked.
    /// @throws Error when it is damaged
    [[nodiscard]] voxel::archive::MadeBox box(const voxel::archive::Entry& entry) const;

private:
    std::unique_ptr<voxel::archive::ByteSource> m_source;
    std::unique_ptr<voxel::archive::ArchiveIndex> m_index;
    std::unique_ptr<voxel::archive::EntryFinder> m_finder;
};

}  // namespace terravox::archive_tools
