#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <vector>

#include "common/voxel/archive/byte_source.hpp"

namespace terravox::archive_tools {

struct Verification;

/// An archive that lies in one file, or in parts of it (split.hpp).
class ArchiveFiles {
public:
    /// Not explicit: most archives are one file.
    ArchiveFiles(std::filesystem::path file) : m_files{std::move(file)} {}
    /// @param parts in their order; not empty
    explicit ArchiveFiles(std::vector<std::filesystem::path> parts) : m_files(std::move(parts)) {}

    /// @throws Error when a file is not there
    [[nodiscard]] std::unique_ptr<voxel::archive::ByteSource> open() const;
    /// @throws Error
    [[nodiscard]] std::uint64_t bytes() const;

private:
    std::vector<std::filesystem::path> m_files;
};

/// Whether a file is the first part of an archive: begins like one, and ends before its end.
[[nodiscard]] bool is_first_part(const std::filesystem::path& file);

/// Joins the parts of an archive again, and verifies all checksums before it appears under its
/// name.
/// @param parts in their order
/// @param out may be a symbolic link, which is followed
/// @return what was verified: no problems
/// @throws Error when a part is missing, damaged or not in its place, or the archive cannot be
/// written
Verification join_parts(const std::vector<std::filesystem::path>& parts,
                        const std::filesystem::path& out, int threads);

}  // namespace terravox::archive_tools
