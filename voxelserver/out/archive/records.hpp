#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/voxel/archive/archive_index.hpp"

namespace terravox::archive_tools {

/// Why a record is not what its entry, or its checksum, says; nullopt: it is.
[[nodiscard]] std::optional<std::string> problem_of(const voxel::archive::Record& record,
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

}  // namespace terravox::archive_tools
