#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "common/voxel/archive/archive_index.hpp"
#include "common/voxel/archive/coarse_levels.hpp"

namespace terravox::archive_tools {

/// An archive, or a change of one, with its whole index in memory. Thread-safe once opened.
class IndexedFile {
public:
    /// @throws Error when it cannot be read, or its index is damaged
    IndexedFile(const std::filesystem::path& file, voxel::archive::ArchiveIndex::Of of);

    [[nodiscard]] voxel::archive::ByteSource& source() const noexcept { return *m_source; }
    [[nodiscard]] const voxel::archive::ArchiveIndex& index() const noexcept { return *m_index; }
    /// In the order of the index.
    [[nodiscard]] const std::vector<voxel::archive::Entry>& entries() const noexcept {
        return m_entries;
    }
    /// @return nullptr: air
    [[nodiscard]] const voxel::archive::Entry* find(const voxel::BoxKey& key) const;
    /// A record as it is in the file.
    /// @throws Error when it is damaged
    [[nodiscard]] voxel::archive::MadeRecord record(const voxel::archive::Entry& entry) const;
    /// A record, unpacked.
    /// @throws Error when it is damaged
    [[nodiscard]] voxel::archive::MadeBox box(const voxel::archive::Entry& entry) const;

private:
    std::unique_ptr<voxel::archive::ByteSource> m_source;
    std::unique_ptr<voxel::archive::ArchiveIndex> m_index;
    std::vector<voxel::archive::Entry> m_entries;
};

}  // namespace terravox::archive_tools
