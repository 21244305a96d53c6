#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string_view>

namespace terravox::util {

/// What becomes of a symbolic link at the name of a file that is written.
enum class Links : bool {
    kFollow,   ///< the file that it leads to is written: a user has named the link
    kReplace,  ///< the file takes its place: for names of our own, in folders of anybody
};

/// A file that appears under its name only when it is complete.
///
/// Write to temporary_path() by any means, or with append(), then commit(): the data are flushed to
/// the disk and the file is renamed over the target. Without commit() the destructor removes the
/// temporary file. The temporary name keeps the extension, for libraries that choose a format by
/// it, and cannot be guessed. Not thread-safe; two processes may write the same target: the last
/// commit replaces the file as a whole.
class AtomicFile {
public:
    /// @throws Error as check_writable()
    explicit AtomicFile(const std::filesystem::path& target, Links links = Links::kFollow);
    ~AtomicFile();
    AtomicFile(const AtomicFile&) = delete;
    AtomicFile& operator=(const AtomicFile&) = delete;

    /// Behind links, where they are followed.
    [[nodiscard]] const std::filesystem::path& target() const noexcept { return m_target; }
    [[nodiscard]] const std::filesystem::path& temporary_path() const noexcept {
        return m_temporary;
    }

    /// Writes `bytes` to the end of the temporary file, which the first call begins, without a
    /// buffer.
    /// @throws Error with the system's reason (disk full, file too large)
    void append(std::span<const std::byte> bytes);
    /// Closes the descriptor of append(), of which a process with many such files may have too few;
    /// commit() closes it, too.
    /// @throws Error as append(): some file systems report it only now
    void close();

    enum class Flush : bool { kNo, kYes };
    /// @param flush  kNo: a power failure may leave a damaged file under the name; for caches that
    /// verify what they read
    /// @throws Error when flushing or renaming fails (disk full, permission)
    void commit(Flush flush = Flush::kYes);

    /// As commit(), but another file of that name stays.
    /// @throws UsageError when there is one; Error as commit()
    void commit_as_new();

private:
    std::filesystem::path m_target;
    std::filesystem::path m_temporary;
    int m_fd = -1;            ///< of append()
    bool m_is_begun = false;  ///< by append()
    bool m_committed = false;
};

/// Writes `bytes` to `target` through an AtomicFile.
/// @throws Error
void write_file_atomically(const std::filesystem::path& target, std::span<const std::byte> bytes,
                           Links links = Links::kFollow);
inline void write_file_atomically(const std::filesystem::path& target, std::string_view text,
                                  Links links = Links::kFollow) {
    write_file_atomically(target, std::as_bytes(std::span(text)), links);
}

/// The file that a name leads to through symbolic links, be it there or not: a writer that renames
/// would put its file in the place of the link.
/// @throws Error for links that lead to themselves, and for one of another user in a folder that
/// others than its owner may write to: it may lead to any file of this user
[[nodiscard]] std::filesystem::path follow_links(const std::filesystem::path& name);

/// @throws Error as follow_links(), and when the folder of `target`, or of what it links to, is
/// missing and cannot be created, or is not writable; UsageError when the target is a folder, a
/// device, a pipe or a socket
void check_writable(const std::filesystem::path& target);

/// Renames a file, whose data are on the disk, to its final name, and waits until the folder has
/// the name on the disk, too: after a power failure, either the old or the new file is there.
/// @throws Error
void rename_durably(const std::filesystem::path& from, const std::filesystem::path& target);

}  // namespace terravox::util
