#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>

namespace terravox::util {

/// A whole file mapped for reading. The pages are the system's cache: they cost memory only while
/// they are used. Immutable, thread-safe. Only for prepared squares: files in a cache folder of
/// this user that programs of Terravox alone write, under another name first, and replace by
/// renaming, so that no page of a map changes. They are hundreds of megabytes of points that
/// several processes share, and readable() and a checksum for each patch find one that a disk or a
/// person has damaged. Files that come from elsewhere (archives, surveys, images) are read into
/// memory instead: what cuts one short while its map is read ends the program (SIGBUS).
class MappedFile {
public:
    /// @return nullptr when there is no such file @throws Error when it cannot be read
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

/// Reads the pages of a part of a mapped file ahead, in one go. To touch pages that are gone would
/// end the program (SIGBUS).
/// @return false when the file no longer holds them: cut short in place, or its disk fails; always
/// true before Linux 5.14
[[nodiscard]] bool readable(std::span<const std::byte> part) noexcept;

}  // namespace terravox::util
