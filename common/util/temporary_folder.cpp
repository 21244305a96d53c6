#include "common/util/temporary_folder.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

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

/// An open folder, locked. It is closed with the process at the latest, and in programs that the
/// process starts.
/// @return -1 where it is not there, is a link, or another process has locked it
int lock_folder(const fs::path& path) noexcept {
    const int folder = ::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
    if (folder >= 0 && ::flock(folder, LOCK_EX | LOCK_NB) != 0) {
        ::close(folder);
        return -1;
    }
    return folder;
}

/// Whether a locked folder is this user's, and still has a name.
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
        const int folder = lock_folder(it->path());
        if (folder < 0)
            continue;
        std::error_code ignored;
        if (is_own(folder))
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
        out.m_lock = lock_folder(name);
        // Before it was locked, another process may have taken it for one that is left.
        if (out.m_lock >= 0 && is_own(out.m_lock)) {
            out.m_path = name;
            return out;
        }
        ::rmdir(name.c_str());
    }
    throw Error(attempt + ": no folder can be made and locked in " + in.string() +
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
