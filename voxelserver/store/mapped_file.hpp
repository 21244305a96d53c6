#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>

namespace terravox::store {

/// A whole file mapped for reading. The pages are the system's cache: they cost memory only while they are used. Immutable, thread-safe.
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

}  // namespace terravox::store
