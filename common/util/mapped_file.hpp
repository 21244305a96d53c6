#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>

namespace terravox::util {

/// A whole file mapped for reading. The pages are the system's cache: they cost memory only while they are used. Immutable, thread-safe.
/// Whoever reads from one that another program may cut short in place asks readable() first.
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

/// Reads the pages of a part of a mapped file ahead, in one go. To touch pages that are gone would end the program (SIGBUS).
/// @return false when the file no longer holds them: cut short in place, or its disk fails; always true before Linux 5.14
[[nodiscard]] bool readable(std::span<const std::byte> part) noexcept;

}  // namespace terravox::util
