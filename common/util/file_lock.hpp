#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace terravox::util {

/// A lock that one process has at a time: on a file, which stays when the lock ends, unless its
/// holder removes it before that. It ends with the process, however that ends, and works between
/// machines where the file system passes locks on, as NFS does. Movable, not thread-safe.
class FileLock {
public:
    /// Creates the file where it does not exist. Within one process, too, a file is locked once.
    /// @return nullopt while another has the lock
    /// @throws Error when the file cannot be opened or locked
    [[nodiscard]] static std::optional<FileLock> try_take(const std::filesystem::path& file);

    /// Whether anybody has the lock. Does not take it, not even for a moment, and creates nothing.
    /// @throws Error when the file exists but cannot be read
    [[nodiscard]] static bool is_taken(const std::filesystem::path& file);

    /// Who has the lock, or had it last: "process 4711 of node7".
    [[nodiscard]] static std::string holder(const std::filesystem::path& file);

    FileLock(FileLock&& other) noexcept;
    FileLock& operator=(FileLock&& other) noexcept;
    FileLock(const FileLock&) = delete;
    FileLock& operator=(const FileLock&) = delete;
    ~FileLock();

private:
    explicit FileLock(int fd) : m_fd(fd) {}
    int m_fd = -1;
};

}  // namespace terravox::util
