#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>

namespace terravox::util {

/// A whole file mapped read-only into memory. The pages are the system's page cache: they cost
/// memory only while they are used. Immutable, thread-safe. Only for prepared squares: files in a
/// cache folder of this user that are written by Terravox programs only, under a temporary name
/// first, and replaced by renaming, so that no page of a mapping changes. They are hundreds of
/// megabytes of points, shared by several processes; readable() and a checksum per patch detect one
/// that was damaged by a disk or by hand. Files from elsewhere (archives, surveys, images) are read
/// into memory instead: truncating a file while its mapping is read ends the program (SIGBUS).
class MappedFile {
public:
    /// @return nullptr when there is no such file
    /// @throws Error when it cannot be read
    static std::shared_ptr<const MappedFile> open(const std::filesystem::path& path);
    ~MappedFile();
    MappedFile(const MappedFile&) = delete;
    MappedFile& operator=(const MappedFile&) = delete;
    [[nodiscard]] std::span<const std::byte> bytes() const noexcept { return {m_data, m_size}; }

private:
    MappedFile(const std::byte* data, std::size_t size) noexcept : m_data(data), m_size(size) {}
    const std::byte* m_data;
    std::size_t m_size;
};

/// Prefaults the pages of a part of a mapped file in one go. Accessing pages that no longer exist
/// would end the program (SIGBUS).
/// @return false when the file no longer holds them: truncated in place, or its disk fails; always
/// true before Linux 5.14
[[nodiscard]] bool readable(std::span<const std::byte> part) noexcept;

}  // namespace terravox::util
