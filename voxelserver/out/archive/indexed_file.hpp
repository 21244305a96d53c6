#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/voxel/archive/archive_reader.hpp"
#include "common/voxel/archive/coarse_levels.hpp"

namespace terravox::archive_tools {

/// Why a record is not what its entry, or its checksum, says; nullopt: it is.
[[nodiscard]] std::optional<std::string> find_problem(const voxel::archive::Record& record,
                                                      const voxel::archive::Entry& entry,
                                                      std::span<const std::byte> frame);

/// Called with an entry, what precedes its frame in the file, and its frame, which is valid until
/// the call returns.
using VisitRecord =
    std::function<void(const voxel::archive::Entry& entry, const voxel::archive::Record& record,
                       std::span<const std::byte> frame)>;
/// Reads records in the order given, many at once where they follow each other in the file. They
/// are not verified.
/// @throws Error where they cannot be read; what `visit` throws
void visit_records(voxel::archive::ByteSource& source,
                   std::span<const voxel::archive::Entry> entries, const VisitRecord& visit);

/// Called with an entry and its frame, which is valid until the call returns.
using UseRecord =
    std::function<void(const voxel::archive::Entry& entry, std::span<const std::byte> frame)>;

/// As visit_records(), and compares each with its entry and its checksum.
/// @param attempt for messages: "merge"
/// @throws Error where a record is not what the index says; what `use` throws
void read_records(voxel::archive::ByteSource& source,
                  std::span<const voxel::archive::Entry> entries, const char* attempt,
                  const UseRecord& use);

/// All entries of an index, in its order. Memory: 32 bytes each.
/// @throws Error
[[nodiscard]] std::vector<voxel::archive::Entry> all_entries(
    const voxel::archive::ArchiveIndex& index);

/// An archive, or a change of one, whose boxes are looked up. Thread-safe once opened.
class IndexedFile {
public:
    /// @throws Error when it cannot be read
    IndexedFile(const std::filesystem::path& file, voxel::archive::ArchiveIndex::Of of);

    [[nodiscard]] voxel::archive::ByteSource& source() const noexcept { return *m_source; }
    [[nodiscard]] const voxel::archive::ArchiveIndex& index() const noexcept { return *m_index; }
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
