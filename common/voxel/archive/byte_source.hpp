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

/// The properties that change when another program writes to a file, truncates it, or puts another
/// one in its place.
struct FileState {
    std::uint64_t bytes = 0;
    std::int64_t changed_s = 0;
    std::int64_t changed_ns = 0;
    std::uint64_t device = 0;
    std::uint64_t number = 0;  ///< of the file, on its device
    friend bool operator==(const FileState&, const FileState&) = default;
};

/// @throws Error when there is no such plain file
[[nodiscard]] FileState file_state(const std::filesystem::path& path);

/// The same as file_source(path), for a file that was looked at before.
/// @throws ChangedError when it has another state now
[[nodiscard]] std::unique_ptr<ByteSource> file_source(const std::filesystem::path& path,
                                                      const FileState& expected);

}  // namespace terravox::voxel::archive
