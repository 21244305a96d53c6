#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

namespace terravox::pointcloud {

/// A file as bytes at offsets; numbers are read as little-endian, as in LAS. Nothing is read twice
/// by itself and nothing beyond the end. For one thread.
class FileBytes {
public:
    /// @param path  of a regular file
    /// @throws Error naming the file when it is missing, not a regular file, or cannot be opened
    explicit FileBytes(std::filesystem::path path);
    ~FileBytes();
    FileBytes(const FileBytes&) = delete;
    FileBytes& operator=(const FileBytes&) = delete;

    [[nodiscard]] std::uint64_t size() const noexcept { return m_size; }
    /// @throws Error when [offset, offset + out.size()) is not all within the file
    void read(std::uint64_t offset, std::span<unsigned char> out) const;
    /// The value whose bytes start at offset, which needs no alignment. @throws Error as read
    template <class T>
    [[nodiscard]] T at(std::uint64_t offset) const {
        T value;
        read(offset, {reinterpret_cast<unsigned char*>(&value), sizeof value});
        return value;
    }
    /// @throws Error "read the point cloud FILE: WHAT", always
    [[noreturn]] void fail(const std::string& what) const;

private:
    std::filesystem::path m_path;
    std::uint64_t m_size = 0;
    int m_file = -1;
};

}  // namespace terravox::pointcloud
