#include "common/util/temporary_folder.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <string_view>
#include <system_error>
#include <utility>

#include "common/util/error.hpp"

namespace terravox::util {

namespace fs = std::filesystem;

namespace {

constexpr std::string_view kBeginning = "terravox-run-";
constexpr std::string_view kRandom = "XXXXXX";

/// Opens a folder. The descriptor is closed in programs that the process starts.
/// @return -1 where it is not there, or is a link
int open_folder(const fs::path& path) noexcept {
    return ::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
}

enum class Lock { kHeld, kHeldByAnother, kNotSupported };

/// Locks an open folder until its last descriptor is closed, with the process at the latest.
Lock lock(int folder) noexcept {
    if (::flock(folder, LOCK_EX | LOCK_NB) == 0)
        return Lock::kHeld;
    return errno == EWOULDBLOCK ? Lock::kHeldByAnother : Lock::kNotSupported;
}

/// Whether an open folder is this user's, and still has a name.
bool is_own(int folder) noexcept {
    struct stat status{};
    return ::fstat(folder, &status) == 0 && status.st_nlink > 0 && status.st_uid == ::geteuid();
}

/// Removes folders whose processes were killed.
void remove_left(const fs::path& from) noexcept {
    std::error_code failed;
    fs::directory_iterator it(from, failed);
    for (const fs::directory_iterator end; !failed && it != end; it.increment(failed)) {
        const std::string name = it->path().filename().string();
        if (name.size() != kBeginning.size() + kRandom.size() || !name.starts_with(kBeginning))
            continue;
        const int folder = open_folder(it->path());
        if (folder < 0)
            continue;
        std::error_code ignored;
        if (lock(folder) == Lock::kHeld && is_own(folder))
            fs::remove_all(it->path(), ignored);
        ::close(folder);
    }
}

}  // namespace

TemporaryFolder TemporaryFolder::make(const std::string& attempt) {
    const fs::path in = fs::temp_directory_path();
    remove_left(in);
    constexpr int kAttempts = 100;
    for (int i = 0; i < kAttempts; ++i) {
        std::string name = (in / kBeginning).string() + std::string(kRandom);
        if (::mkdtemp(name.data()) == nullptr)
            break;
        TemporaryFolder out;
        out.m_lock = open_folder(name);
        // Before it was locked, another process may have taken it for one that is left. Where the
        // file system has no locks, no process can do so.
        if (out.m_lock >= 0 && lock(out.m_lock) != Lock::kHeldByAnother && is_own(out.m_lock)) {
            out.m_path = name;
            return out;
        }
        ::rmdir(name.c_str());
    }
    throw Error(attempt + ": no folder can be made in " + in.string() +
                "; TMPDIR names another place");
}

TemporaryFolder::TemporaryFolder(TemporaryFolder&& other) noexcept
    : m_path(std::exchange(other.m_path, {})), m_lock(std::exchange(other.m_lock, -1)) {}

TemporaryFolder& TemporaryFolder::operator=(TemporaryFolder&& other) noexcept {
    std::swap(m_path, other.m_path);
    std::swap(m_lock, other.m_lock);
    return *this;
}

TemporaryFolder::~TemporaryFolder() {
    remove();
}

void TemporaryFolder::remove() noexcept {
    constexpr int kAttempts = 100;
    for (int i = 0; i < kAttempts && !m_path.empty(); ++i) {
        std::error_code failed;
        fs::remove_all(m_path, failed);
        if (!failed)
            m_path.clear();
    }
    if (m_lock >= 0)
        ::close(std::exchange(m_lock, -1));
}

}  // namespace terravox::util
