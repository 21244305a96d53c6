#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace terravox::voxel::archive {

/// Where the bytes of an archive come from. Thread-safe.
class ByteSource {
public:
    ByteSource() = default;
    ByteSource(const ByteSource&) = delete;
    ByteSource& operator=(const ByteSource&) = delete;
    virtual ~ByteSource() = default;
    [[nodiscard]] virtual const std::string& name() const noexcept = 0;  ///< for messages
    /// @param room where the bytes go, unless the source keeps them in memory
    /// @return `bytes` bytes from `offset` on, which do not change as long as the source and `room`
    /// live
    /// @throws Error when they cannot be read; ChangedError when the archive is no longer the one
    /// that was opened
    [[nodiscard]] virtual std::span<const std::byte> read(std::uint64_t offset, std::size_t bytes,
                                                          std::vector<std::byte>& room) = 0;
    [[nodiscard]] virtual std::string edition() const { return {}; }  ///< as World::edition
    virtual void stop() noexcept {}                                   ///< as World::stop
    [[nodiscard]] virtual int useful_concurrency(int threads) const noexcept {
        return threads;
    }  ///< as World::useful_concurrency
};

/// A file. Cut short or written to while it is open, it gives a ChangedError and no bytes; replaced
/// by a file that is renamed to its name, it stays the one that was opened. @throws Error when
/// there is no such plain file, or it cannot be read
[[nodiscard]] std::unique_ptr<ByteSource> file_source(const std::filesystem::path& path);

}  // namespace terravox::voxel::archive
