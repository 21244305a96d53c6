#include "common/util/file_lock.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <utility>

#include "common/util/error.hpp"
#include "common/util/files.hpp"
#include "common/util/printable.hpp"

namespace terravox::util {
namespace {

/// The whole file. Locks of open file descriptions (OFD) rather than flock(): they can be queried
/// without being taken, and NFS passes them on.
struct flock whole_file() noexcept {
    struct flock lock{};
    lock.l_type = F_WRLCK;
    lock.l_whence = SEEK_SET;
    return lock;
}

Error failed(const std::filesystem::path& file) {
    return Error("lock " + file.string() + ": " + std::strerror(errno));
}

/// Writes the process and the machine into the file; only messages show it, so a full disk does not
/// matter.
void sign(int fd) noexcept {
    std::array<char, 256> host{};
    if (::gethostname(host.data(), host.size() - 1) != 0)
        host[0] = '?';
    std::array<char, 320> line{};
    const int size = std::snprintf(line.data(), line.size(), "process %d of %s\n",
                                   static_cast<int>(::getpid()), host.data());
    if (size <= 0 || ::ftruncate(fd, 0) != 0)
        return;
    [[maybe_unused]] const auto written =
        ::pwrite(fd, line.data(), static_cast<std::size_t>(size), 0);
}

}  // namespace

std::optional<FileLock> FileLock::try_take(const std::filesystem::path& file) {
    for (;;) {
        FileLock out(open_to_write(file, O_RDWR | O_CREAT, 0644, "lock " + file.string()));
        struct flock lock = whole_file();
        if (::fcntl(out.m_fd, F_OFD_SETLK, &lock) != 0) {
            if (errno == EAGAIN || errno == EACCES)
                return std::nullopt;
            throw failed(file);
        }
        // Else the one who had the lock has removed the file meanwhile, and a third one may lock
        // the next file of that name.
        if (is_named(out.m_fd, file)) {
            sign(out.m_fd);
            return out;
        }
    }
}

bool FileLock::is_taken(const std::filesystem::path& file) {
    const int fd = ::open(file.c_str(), O_RDONLY | O_CLOEXEC);
    if (fd < 0) {
        if (errno == ENOENT)
            return false;
        throw failed(file);
    }
    struct flock lock = whole_file();
    const bool asked = ::fcntl(fd, F_OFD_GETLK, &lock) == 0;
    const int code = errno;
    ::close(fd);
    errno = code;
    if (!asked)
        throw failed(file);
    return lock.l_type != F_UNLCK;
}

std::string FileLock::holder(const std::filesystem::path& file) {
    std::ifstream in(file);
    std::string line;
    constexpr std::size_t kMost = 300;
    if (!std::getline(in, line) || line.empty() || line.size() > kMost)
        return "another process";
    return printable(line);
}

FileLock::FileLock(FileLock&& other) noexcept : m_fd(std::exchange(other.m_fd, -1)) {}

FileLock& FileLock::operator=(FileLock&& other) noexcept {
    std::swap(m_fd, other.m_fd);
    return *this;
}

FileLock::~FileLock() {
    if (m_fd >= 0)
        ::close(m_fd);
}

}  // namespace terravox::util
