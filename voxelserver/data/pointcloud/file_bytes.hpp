#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "common/util/files.hpp"

namespace terravox::pointcloud {

/// Random access to the bytes of a file; numbers are read as little-endian, as in LAS. Nothing is
/// cached, and reads beyond the end are refused. For use by one thread.
class FileBytes {
public:
    /// @param path  a regular file
    /// @throws Error naming the file when it is missing, not a regular file, or cannot be opened
    explicit FileBytes(std::filesystem::path path);

    [[nodiscard]] const std::filesystem::path& path() const noexcept { return m_path; }
    [[nodiscard]] std::uint64_t size() const noexcept { return m_size; }
    /// @throws Error when [offset, offset + out.size()) is not entirely within the file
    void read(std::uint64_t offset, std::span<unsigned char> out) const;
    /// The value whose bytes start at `offset`, which need not be aligned.
    /// @throws Error as read
    template <class T>
    [[nodiscard]] T at(std::uint64_t offset) const {
        T value;
        read(offset, {reinterpret_cast<unsigned char*>(&value), sizeof value});
        return value;
    }
    /// @throws Error always: "read the point cloud FILE: WHAT"
    [[noreturn]] void fail(const std::string& what) const;

private:
    std::filesystem::path m_path;
    std::uint64_t m_size = 0;
    util::Descriptor m_file;
};

}  // namespace terravox::pointcloud
