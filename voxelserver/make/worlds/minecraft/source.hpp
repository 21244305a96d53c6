#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/util/cache.hpp"
#include "common/util/files.hpp"

namespace terravox::minecraft {

/// Bytes with random access, readable by several threads at once.
class ByteFile {
public:
    virtual ~ByteFile() = default;
    [[nodiscard]] virtual std::uint64_t size() const noexcept = 0;
    /// Fills `out` from `offset` on.
    /// @throws Error when that lies past the end, or cannot be read
    virtual void read(std::uint64_t offset, std::span<std::uint8_t> out) const = 0;
};

/// The files of a folder and of the folders in it, of a ZIP file, or one file alone. Thread-safe.
///
/// A file of a ZIP file is unpacked on request: into memory, or, when large, into an unnamed
/// temporary file that vanishes by itself. The most recently used ones are kept under a byte limit.
/// Files whose names lead outside (absolute, with `..`) are rejected.
class FileSource {
public:
    static constexpr std::uint64_t kMaxEntries = std::uint64_t{1} << 22;
    /// The size of a region of 1024 chunks of 1 MiB.
    static constexpr std::uint64_t kMaxFileBytes = (std::uint64_t{1} << 30) + 8192;

    struct Entry {
        /// From the source's root, with '/' as separator; for one file alone: its name.
        std::string path;
        std::uint64_t bytes = 0;
    };

    virtual ~FileSource() = default;
    FileSource(const FileSource&) = delete;
    FileSource& operator=(const FileSource&) = delete;

    /// Sorted by path, each path once.
    [[nodiscard]] const std::vector<Entry>& entries() const noexcept { return m_entries; }
    [[nodiscard]] std::optional<std::size_t> find(std::string_view path) const noexcept;
    /// @throws Error when it cannot be opened or unpacked, e.g. because it unpacks to more than
    /// kMaxFileBytes
    [[nodiscard]] std::shared_ptr<const ByteFile> open(std::size_t entry);
    /// The first bytes, at most `most`; of packed files, no more than these are unpacked.
    /// @throws Error
    [[nodiscard]] virtual std::vector<std::uint8_t> head(std::size_t entry, std::size_t most) = 0;
    /// The whole file.
    /// @throws Error, also when it is larger than `most`
    [[nodiscard]] std::vector<std::uint8_t> whole(std::size_t entry, std::size_t most);
    /// What was rejected or skipped, one line each.
    [[nodiscard]] const std::vector<std::string>& refused() const noexcept { return m_refused; }

protected:
    explicit FileSource(std::size_t cache_bytes) : m_open(cache_bytes) {}
    void set_entries(std::vector<Entry> entries, std::vector<std::string> refused);
    struct Opened {
        std::shared_ptr<const ByteFile> file;
        std::size_t weight_bytes = 0;
    };
    [[nodiscard]] virtual Opened open_anew(std::size_t entry) = 0;

    std::vector<Entry> m_entries;

private:
    util::Cache<std::size_t, Opened> m_open;
    std::mutex m_failed_mutex;
    std::map<std::size_t, std::string> m_failed;  ///< entries that could not be opened, and why
    std::vector<std::string> m_refused;
};

/// @param cache_bytes limit of what is kept open or unpacked
/// @throws UsageError when there is nothing at `path`, or more than a source may hold; Error when
/// it cannot be read
[[nodiscard]] std::unique_ptr<FileSource> open_source(const std::filesystem::path& path,
                                                      std::size_t cache_bytes);

/// A file on disk, read by position: if it becomes shorter while it is open, reads throw, where a
/// mapped file would crash.
class DiskFile final : public ByteFile {
public:
    /// @throws Error when it cannot be opened
    explicit DiskFile(const std::filesystem::path& path);
    /// Takes over an open file.
    /// @param name for messages
    /// @throws Error
    DiskFile(util::Descriptor file, std::string name);

    [[nodiscard]] std::uint64_t size() const noexcept override { return m_size; }
    void read(std::uint64_t offset, std::span<std::uint8_t> out) const override;

private:
    util::Descriptor m_file;
    std::uint64_t m_size = 0;
    std::string m_name;
};

/// The files of a ZIP file.
/// @throws Error when it is not a ZIP file, or holds more than FileSource::kMaxEntries
[[nodiscard]] std::unique_ptr<FileSource> open_zip(const std::filesystem::path& path,
                                                   std::size_t cache_bytes);

}  // namespace terravox::minecraft
