#pragma once

#include <filesystem>

#include "voxelserver/make/worlds/minecraft/source.hpp"

namespace terravox::minecraft {

/// A file on disk, read by position: if it becomes shorter while it is open, reads throw, where a
/// mapped file would crash.
class DiskFile final : public ByteFile {
public:
    /// @throws Error when it cannot be opened
    explicit DiskFile(const std::filesystem::path& path);
    /// Takes over an open file.
    /// @param name for messages
    /// @throws Error
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
