#include "common/util/atomic_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <random>
#include <string>
#include <system_error>
#include <utility>

#include "common/util/error.hpp"
#include "common/util/write_all.hpp"

namespace terravox::util {
namespace {

std::filesystem::path folder_of(const std::filesystem::path& target) {
    const auto folder = target.parent_path();
    return folder.empty() ? std::filesystem::path(".") : folder;
}

std::string reason(int code) {
    return std::strerror(code);
}

// The process id and a counter distinguish two writers of one target, in one process or in two. The
// counter begins anywhere: writers on two machines may have one process id.
std::filesystem::path temporary_name(const std::filesystem::path& target) {
    static std::atomic<unsigned> counter{std::random_device{}()};
    const auto name = "." + target.stem().string() + ".part-" + std::to_string(::getpid()) + "-" +
                      std::to_string(counter++) + target.extension().string();
    return folder_of(target) / name;
}

void flush_to_disk(const std::filesystem::path& path) {
    const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
    if (fd < 0)
        throw Error("write " + path.string() + ": " + reason(errno));
    const int failed = ::fsync(fd) == 0 ? 0 : errno;
    ::close(fd);
    // Some file systems (network, FUSE) do not support fsync: that is not an error.
    if (failed != 0 && failed != EINVAL && failed != ENOTSUP)
        throw Error("write " + path.string() + ": " + reason(failed));
}

void rename_file(const std::filesystem::path& from, const std::filesystem::path& target) {
    std::error_code failed;
    std::filesystem::rename(from, target, failed);
    if (failed)
        throw Error("write " + target.string() +
                    ": cannot rename the finished file: " + failed.message());
}

}  // namespace

void check_writable(const std::filesystem::path& target) {
    std::error_code failed;
    std::error_code ignored;
    const std::filesystem::path file = follow_links(target);
    if (file.filename().empty() || std::filesystem::is_directory(file, ignored))
        throw UsageError("write " + target.string() + ": this is a folder; give a file name");
    // A file would be renamed over it.
    if (std::filesystem::exists(file, ignored) && !std::filesystem::is_regular_file(file, ignored))
        throw UsageError("write " + target.string() +
                         ": this is a device, a pipe or a socket; give a file name");
    const auto folder = folder_of(file);
    std::filesystem::create_directories(folder, failed);
    if (!std::filesystem::is_directory(folder, ignored))
        throw Error("write " + target.string() + ": cannot make the folder " + folder.string() +
                    ": " + (failed ? failed.message() : "a file of that name exists"));
    if (::access(folder.c_str(), W_OK) != 0)
        throw Error("write " + target.string() + ": the folder " + folder.string() +
                    " is not writable: " + reason(errno));
}

std::filesystem::path follow_links(const std::filesystem::path& name) {
    constexpr int kMaxLinks = 40;  // as Linux
    std::filesystem::path at = name;
    for (int followed = 0; followed <= kMaxLinks; ++followed) {
        std::error_code failed;
        if (!std::filesystem::is_symlink(at, failed))
            return at;
        const std::filesystem::path to = std::filesystem::read_symlink(at, failed);
        if (failed)
            throw Error("write " + name.string() + ": " + failed.message());
        at = at.parent_path() / to;
    }
    throw Error("write " + name.string() + ": too many symbolic links");
}

AtomicFile::AtomicFile(const std::filesystem::path& target)
    : m_target(follow_links(target)), m_temporary(temporary_name(m_target)) {
    check_writable(target);
}

AtomicFile::~AtomicFile() {
    if (m_fd >= 0)
        ::close(m_fd);
    std::error_code ignored;
    if (!m_committed)
        std::filesystem::remove(m_temporary, ignored);
}

void rename_durably(const std::filesystem::path& from, const std::filesystem::path& target) {
    rename_file(from, target);
    const auto folder = folder_of(target);
    // A folder that may be written but not listed cannot be opened, nor be flushed.
    if (::access(folder.c_str(), R_OK) == 0)
        flush_to_disk(folder);
}

void AtomicFile::append(std::span<const std::byte> bytes) {
    if (m_fd < 0) {
        // A killed process may have left a file of this name.
        const int begin = m_is_begun ? 0 : O_TRUNC;
        m_fd = ::open(m_temporary.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC | begin, 0666);
        if (m_fd < 0)
            throw Error("write " + m_target.string() + ": " + reason(errno));
        m_is_begun = true;
    }
    if (const int failed = write_all(m_fd, bytes); failed != 0)
        throw Error("write " + m_target.string() + ": " + reason(failed));
}

void AtomicFile::close() {
    if (m_fd >= 0 && ::close(std::exchange(m_fd, -1)) != 0)
        throw Error("write " + m_target.string() + ": " + reason(errno));
}

void AtomicFile::commit(Flush flush) {
    close();
    if (flush == Flush::kYes)
        flush_to_disk(m_temporary);
    rename_file(m_temporary, m_target);
    m_committed = true;
}

void AtomicFile::commit_as_new() {
    close();
    flush_to_disk(m_temporary);
    bool is_renamed = ::renameat2(AT_FDCWD, m_temporary.c_str(), AT_FDCWD, m_target.c_str(),
                                  RENAME_NOREPLACE) == 0;
    // Some file systems (NFS) know only links that do not replace.
    if (!is_renamed && (errno == EINVAL || errno == ENOSYS)) {
        is_renamed = ::link(m_temporary.c_str(), m_target.c_str()) == 0;
        if (is_renamed)
            ::unlink(m_temporary.c_str());
    }
    if (!is_renamed && errno == EEXIST)
        throw UsageError("write " + m_target.string() +
                         ": it is there already; allowed: another name");
    if (!is_renamed)
        throw Error("write " + m_target.string() + ": " + reason(errno));
    m_committed = true;
}

void write_file_atomically(const std::filesystem::path& target, std::span<const std::byte> bytes) {
    AtomicFile file(target);
    file.append(bytes);
    file.commit();
}

}  // namespace terravox::util
