#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace terravox::voxel::archive {

/// Random access to the bytes of an archive. Thread-safe.
class ByteSource {
public:
    ByteSource() = default;
    ByteSource(const ByteSource&) = delete;
    ByteSource& operator=(const ByteSource&) = delete;
    virtual ~ByteSource() = default;
    [[nodiscard]] virtual const std::string& name() const noexcept = 0;  ///< for messages
    /// @param room buffer for the bytes; unused when the source keeps them in memory
    /// @return `bytes` bytes from `offset`, unchanged during the lifetime of the source and of
    /// `room`
    /// @throws Error when they cannot be read; ChangedError when the archive is no longer the one
    /// that was opened
    [[nodiscard]] virtual std::span<const std::byte> read(std::uint64_t offset, std::size_t bytes,
                                                          std::vector<std::byte>& room) = 0;
    [[nodiscard]] virtual std::string edition() const { return {}; }  ///< as World::edition
    virtual void stop() noexcept {}                                   ///< as World::stop
    /// As World::useful_concurrency.
    [[nodiscard]] virtual int useful_concurrency(int threads) const noexcept { return threads; }
};

/// A byte source that reads a file. When the file is truncated or modified while it is open, read()
/// throws a ChangedError and returns no bytes; when it is replaced by renaming another file to its
/// name, the source keeps reading the original one.
/// @throws Error when there is no such plain file, or it cannot be read
[[nodiscard]] std::unique_ptr<ByteSource> file_source(const std::filesystem::path& path);

}  // namespace terravox::voxel::archive
