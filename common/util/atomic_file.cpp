#include "common/util/atomic_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <random>
#include <string>
#include <system_error>
#include <utility>

#include "common/util/error.hpp"
#include "common/util/files.hpp"

namespace terravox::util {
namespace {

std::filesystem::path find_folder(const std::filesystem::path& target) {
    const auto folder = target.parent_path();
    return folder.empty() ? std::filesystem::path(".") : folder;
}

std::string reason(int code) {
    return std::strerror(code);
}

// The process says who has left a file. The rest distinguishes two writers of one target, on one
// machine or on two, and cannot be guessed: where others may write to the folder, they cannot have
// put a link there, which libraries that are told this name would follow.
std::filesystem::path temporary_name(const std::filesystem::path& target) {
    std::random_device random;
    std::array<char, 2 * 8 + 1> digits{};
    std::snprintf(digits.data(), digits.size(), "%08x%08x", random(), random());
    const auto name = "." + target.stem().string() + ".part-" + std::to_string(::getpid()) + "-" +
                      digits.data() + target.extension().string();
    return find_folder(target) / name;
}

/// Whether a link may be followed by a program that writes: it is this user's or the system's, or
/// nobody but its owner can have put it where it is.
bool is_trusted(const std::filesystem::path& link) noexcept {
    struct stat facts{};
    struct stat folder{};
    if (::lstat(link.c_str(), &facts) != 0 || ::stat(find_folder(link).c_str(), &folder) != 0)
        return false;
    if (facts.st_uid == ::geteuid() || facts.st_uid == 0)
        return true;
    return facts.st_uid == folder.st_uid && (folder.st_mode & (S_IWGRP | S_IWOTH)) == 0;
}

/// @param name for messages
/// @param file the same, behind links that are followed
void check_place(const std::filesystem::path& name, const std::filesystem::path& file) {
    std::error_code failed;
    std::error_code ignored;
    const auto type = std::filesystem::symlink_status(file, ignored).type();
    if (file.filename().empty() || type == std::filesystem::file_type::directory)
        throw UsageError("write {}: this is a folder; give a file name", name.string());
    // A file would be renamed over it.
    if (type == std::filesystem::file_type::block ||
        type == std::filesystem::file_type::character || type == std::filesystem::file_type::fifo ||
        type == std::filesystem::file_type::socket)
        throw UsageError("write {}: this is a device, a pipe or a socket; give a file name",
                         name.string());
    const auto folder = find_folder(file);
    std::filesystem::create_directories(folder, failed);
    if (!std::filesystem::is_directory(folder, ignored))
        throw Error("write {}: cannot make the folder {}: {}", name.string(), folder.string(),
                    failed ? failed.message() : "a file of that name exists");
    if (::access(folder.c_str(), W_OK) != 0)
        throw Error("write {}: the folder {} is not writable: {}", name.string(), folder.string(),
                    reason(errno));
}

void flush_to_disk(const std::filesystem::path& path) {
    const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
    if (fd < 0)
        throw Error("write {}: {}", path.string(), reason(errno));
    const int failed = ::fsync(fd) == 0 ? 0 : errno;
    ::close(fd);
    // Some file systems (network, FUSE) do not support fsync: that is not an error.
    if (failed != 0 && failed != EINVAL && failed != ENOTSUP)
        throw Error("write {}: {}", path.string(), reason(failed));
}

void rename_file(const std::filesystem::path& from, const std::filesystem::path& target) {
    std::error_code failed;
    std::filesystem::rename(from, target, failed);
    if (failed)
        throw Error("write {}: cannot rename the finished file: {}", target.string(),
                    failed.message());
}

}  // namespace

void check_writable(const std::filesystem::path& target) {
    check_place(target, follow_links(target));
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
            throw Error("write {}: {}", name.string(), failed.message());
        if (!is_trusted(at))
            throw Error(
                "write {}: {} is a symbolic link of another user, in a folder that others may "
                "write to; allowed: the name that it leads to, {}",
                name.string(), at.string(), to.string());
        at = at.parent_path() / to;
    }
    throw Error("write {}: too many symbolic links", name.string());
}

AtomicFile::AtomicFile(const std::filesystem::path& target, Links links)
    : m_target(links == Links::kFollow ? follow_links(target) : target),
      m_temporary(temporary_name(m_target)) {
    check_place(target, m_target);
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
    const auto folder = find_folder(target);
    // A folder that may be written but not listed cannot be opened, nor be flushed.
    if (::access(folder.c_str(), R_OK) == 0)
        flush_to_disk(folder);
}

void AtomicFile::append(std::span<const std::byte> bytes) {
    if (m_fd < 0) {
        m_fd = open_to_write(m_temporary, O_WRONLY | O_APPEND | (m_is_begun ? 0 : O_CREAT | O_EXCL),
                             0666, "write " + m_target.string());
        m_is_begun = true;
    }
    if (const int failed = write_all(m_fd, bytes); failed != 0)
        throw Error("write {}: {}", m_target.string(), reason(failed));
}

void AtomicFile::close() {
    if (m_fd >= 0 && ::close(std::exchange(m_fd, -1)) != 0)
        throw Error("write {}: {}", m_target.string(), reason(errno));
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
        throw UsageError("write {}: it is there already; allowed: another name", m_target.string());
    if (!is_renamed)
        throw Error("write {}: {}", m_target.string(), reason(errno));
    m_committed = true;
}

void write_file_atomically(const std::filesystem::path& target, std::span<const std::byte> bytes,
                           Links links) {
    AtomicFile file(target, links);
    file.append(bytes);
    file.commit();
}

}  // namespace terravox::util
