#pragma once

#include <filesystem>

#include "voxelserver/worlds/minecraft/source.hpp"

namespace terravox::minecraft {

/// A file on disk, read by position: one that becomes shorter while it is open is an error, not a
/// crash as it would be mapped.
class DiskFile final : public ByteFile {
public:
    explicit DiskFile(
        const std::filesystem::path& path);  ///< @throws Error when it cannot be opened
    /// Takes over a file that is open. @param name for messages @throws Error
    DiskFile(int descriptor, std::string name);
    ~DiskFile() override;
    DiskFile(const DiskFile&) = delete;
    DiskFile& operator=(const DiskFile&) = delete;

    [[nodiscard]] std::uint64_t size() const noexcept override { return m_size; }
    void read(std::uint64_t offset, std::span<std::uint8_t> out) const override;

private:
    void measure();
    int m_descriptor = -1;
    std::uint64_t m_size = 0;
    std::string m_name;
};

}  // namespace terravox::minecraft
