#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace terravox::util {

/// Replaces each folder in `paths` by the files in it that have one of the endings (lower case,
/// with dot; matched case-insensitively), sorted by name. Files are kept, whatever their ending. A
/// file that is named twice is kept once, even when its names differ (`./a`, links): under the name
/// that sorts first, so that the choice does not depend on the order of `paths`.
/// @param what the kind of file, for messages, e.g. "LiDAR data"
/// @throws UsageError for a folder without such a file, or a path that does not exist
[[nodiscard]] std::vector<std::filesystem::path> expand_folders(
    const std::vector<std::filesystem::path>& paths,
    std::initializer_list<std::string_view> endings, std::string_view what);

/// The same, for cases where the ending alone is not sufficient.
/// @param belongs whether to take a file of a folder that has one of the endings
[[nodiscard]] std::vector<std::filesystem::path> expand_folders(
    const std::vector<std::filesystem::path>& paths, std::span<const std::string_view> endings,
    std::string_view what, const std::function<bool(const std::filesystem::path&)>& belongs);

/// An open file; closed at the end. Movable, not thread-safe.
class Descriptor {
public:
    explicit Descriptor(int fd = -1) noexcept : m_fd(fd) {}  ///< -1: none
    Descriptor(Descriptor&& other) noexcept : m_fd(std::exchange(other.m_fd, -1)) {}
    Descriptor& operator=(Descriptor&& other) noexcept {
        std::swap(m_fd, other.m_fd);
        return *this;
    }
    ~Descriptor() { close(); }
    [[nodiscard]] int get() const noexcept { return m_fd; }
    void close() noexcept;

private:
    int m_fd;
};

/// The ends of a new pipe, which programs that are started do not get.
struct Pipe {
    Descriptor reading;
    Descriptor writing;
};
/// @param attempt begins the message
/// @throws Error
[[nodiscard]] Pipe open_pipe(const std::string& attempt);

/// Told what is wrong with a file ("no such file"); throws.
using FailToRead = std::function<void(const std::string& what)>;

/// A plain file as a text, whatever its bytes, without the mark of UTF-8 that other programs may
/// begin it with. Any other kind is not even opened: that could wait
/// for a writer, or be read without end.
/// @param limit_bytes of a longer file no more than that is read, whatever length it reports
/// @throws what `fail` throws: "no such file", "not a plain file", "more than 1 MiB; allowed: up to
/// that", or the system's reason
[[nodiscard]] std::string read_text(const std::filesystem::path& file, std::size_t limit_bytes,
                                    const FailToRead& fail);
/// @param attempt begins the message: "read the plan a.json"
/// @throws Error
[[nodiscard]] std::string read_text(const std::filesystem::path& file, std::size_t limit_bytes,
                                    const std::string& attempt);
/// @return nullopt where the other ones throw
[[nodiscard]] std::optional<std::string> try_read_text(const std::filesystem::path& file,
                                                       std::size_t limit_bytes);

/// The first bytes of a plain file, fewer where it is shorter; none of what cannot be read.
[[nodiscard]] std::string read_start(const std::filesystem::path& file, std::size_t bytes);

/// Opens a file to write to it in its place: a lock, a journal, an archive that grows. Never
/// through a symbolic link at its name, nor anything but a plain file: where others may write to
/// the folder, they could have put there what leads to any file of this user.
/// @param flags of open(2), for writing; O_CLOEXEC and O_NOFOLLOW are added
/// @param mode of a new file
/// @param attempt begins the message: "lock a.lock"
/// @throws Error
[[nodiscard]] int open_to_write(const std::filesystem::path& file, int flags, unsigned mode,
                                const std::string& attempt);

/// Opens a new file to read and write, without a name: it is gone once it is closed.
/// @param near a file in whose folder it takes room
/// @param attempt begins the message
/// @throws Error
[[nodiscard]] int open_unnamed(const std::filesystem::path& near, const std::string& attempt);

/// Whether an open file still has this name. A file that is locked by its name has to be opened
/// again where it has not: in between, another process may have removed or replaced it.
/// @param fd of the open file
[[nodiscard]] bool is_named(int fd, const std::filesystem::path& name) noexcept;

/// Whether a folder holds a regular file for which `is` is true; false for a folder that cannot be
/// read. Not recursive.
template <class Is>
[[nodiscard]] bool any_file(const std::filesystem::path& folder, const Is& is) {
    std::error_code failed;
    std::filesystem::directory_iterator it(folder, failed);
    for (const std::filesystem::directory_iterator end; !failed && it != end;
         it.increment(failed)) {
        if (it->is_regular_file(failed) && is(it->path()))
            return true;
    }
    return false;
}

/// Writes all bytes at the position of an open file, in as many calls as that takes.
/// @return 0, or errno of the call that failed: then some of the bytes may be written
[[nodiscard]] int write_all(int fd, std::span<const std::byte> bytes) noexcept;

/// Raises this process's limit of open file descriptors to its maximum (the soft limit becomes the
/// hard one): a server needs some for each client.
void raise_open_file_limit() noexcept;

/// A whole file mapped read-only into memory. The pages are the system's page cache: they cost
/// memory only while they are used. Immutable, thread-safe. Only for prepared squares: files in a
/// cache folder of this user that are written by Terravox programs only, under a temporary name
/// first, and replaced by renaming, so that no page of a mapping changes. They are hundreds of
/// megabytes of points, shared by several processes; readable() and a checksum per patch detect one
/// that was damaged by a disk or by hand. Files from elsewhere (archives, surveys, images) are read
/// into memory instead: truncating a file while its mapping is read ends the program (SIGBUS).
class MappedFile {
public:
    /// @return nullptr when there is no such file
    /// @throws Error when it cannot be read
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

/// Prefaults the pages of a part of a mapped file in one go. Accessing pages that no longer exist
/// would end the program (SIGBUS).
/// @return false when the file no longer holds them: truncated in place, or its disk fails; always
/// true before Linux 5.14
[[nodiscard]] bool readable(std::span<const std::byte> part) noexcept;

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

private:
    explicit FileLock(int fd) : m_file(fd) {}
    Descriptor m_file;
};

}  // namespace terravox::util
