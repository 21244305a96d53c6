#include "common/util/folders.hpp"

#include <dlfcn.h>
#include <fcntl.h>
#include <link.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>
#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "common/util/error.hpp"
#include "common/util/text.hpp"

namespace terravox::util {

std::filesystem::path own_file() {
    std::error_code ignored;
    Dl_info symbol{};
    void* object = nullptr;
    const auto* const here = reinterpret_cast<const void*>(&own_file);
    if (dladdr1(here, &symbol, &object, RTLD_DL_LINKMAP) != 0 && object != nullptr) {
        // The name of the program itself is empty here.
        const std::string name = static_cast<const link_map*>(object)->l_name;
        if (!name.empty())
            return std::filesystem::canonical(name, ignored);
    }
    return std::filesystem::read_symlink("/proc/self/exe", ignored);
}

std::filesystem::path beside_program(std::string_view name) {
    return own_file().parent_path() / name;
}

bool has_version(const std::filesystem::path& library) {
    return library.filename().string().find(".so.") != std::string::npos;
}

std::filesystem::path module_file(std::string_view name) {
    const std::filesystem::path own = own_file();
    if (has_version(own))
        return own.parent_path() / "terravox" / own.filename() / name;
    return own.parent_path() / name;
}

namespace {

// log4cplus::shutdownThreadPool(), where OpenVDB is built with log4cplus, as in Debian.
constexpr const char* kEndLogThreads = "_ZN9log4cplus18shutdownThreadPoolEv";

bool has_log4cplus() {
    return dl_iterate_phdr(
               [](dl_phdr_info* object, std::size_t /*size*/, void* /*unused*/) {
                   return std::strstr(object->dlpi_name, "/liblog4cplus") != nullptr ? 1 : 0;
               },
               nullptr) != 0;
}

}  // namespace

void* open_module(std::string_view name, std::string_view what) {
    const std::filesystem::path file = module_file(name);
    const bool is_another_s = has_log4cplus();
    // Never closed: threads, exceptions and objects of the library may outlive the caller that
    // opened it.
    if (void* library = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL)) {
        // log4cplus starts threads when it is loaded, for appenders that nobody here has. Where a
        // process forks later, the child would wait for them at its end, for ever.
        if (auto* end = reinterpret_cast<void (*)()>(dlsym(library, kEndLogThreads));
            end != nullptr && !is_another_s)
            end();
        return library;
    }
    const char* why = dlerror();
    throw Error("load the {} {}: {}", what, file.string(), why != nullptr ? why : "unknown error");
}

std::filesystem::path config_dir() {
    namespace fs = std::filesystem;
    const auto holds_config = [](const fs::path& p) {
        std::error_code ignored;
        return fs::is_regular_file(p / "materials.toml", ignored);
    };
    if (const char* folder = std::getenv("TERRAVOX_CONFIG"); folder != nullptr && *folder != '\0') {
        if (holds_config(folder))
            return folder;
        throw UsageError("find the configuration: TERRAVOX_CONFIG = '{}' holds no materials.toml",
                         folder);
    }
    const fs::path program = own_file();
    std::vector<fs::path> places{"config", "share/terravox/config"};
    if (has_version(program))
        places.insert(places.begin() + 1, "share/terravox" / program.filename() / "config");
    std::string tried;
    fs::path folder = program.parent_path();
    // build/<preset>/bin is three levels below the root of the sources; an installed bin/ is one
    // below its prefix.
    for (int up = 0; up < 5 && !folder.empty(); ++up, folder = folder.parent_path())
        for (const fs::path& place : places) {
            const fs::path candidate = folder / place;
            if (holds_config(candidate))
                return candidate;
            tried += (tried.empty() ? "" : ", ") + candidate.string();
        }
    throw Error("find the configuration: no materials.toml in {}; set TERRAVOX_CONFIG", tried);
}

std::vector<std::string> toml_id_list(const std::filesystem::path& folder) {
    std::vector<std::string> ids;
    std::error_code ignored;
    for (const auto& entry : std::filesystem::directory_iterator(folder, ignored))
        if (entry.path().extension() == ".toml")
            ids.push_back(entry.path().stem().string());
    std::sort(ids.begin(), ids.end());
    return ids;
}

std::string toml_ids(const std::filesystem::path& folder) {
    return comma_list(toml_id_list(folder));
}

std::filesystem::path base_file(const std::filesystem::path& file, const std::string& id,
                                const std::string& kind) {
    const std::string name = id + ".toml";
    std::error_code ignored;
    if (auto neighbour = file.parent_path() / name; std::filesystem::exists(neighbour, ignored))
        return neighbour;
    if (auto shipped = config_dir() / kind / name; std::filesystem::exists(shipped, ignored))
        return shipped;
    return {};
}

std::filesystem::path cache_dir(const std::string& given) {
    if (given == "none")
        return {};
    if (!given.empty())
        return given;
    const auto variable = [](const char* name) -> std::filesystem::path {
        const char* value = std::getenv(name);
        return value == nullptr ? "" : value;
    };
    // The XDG specification requires relative paths to be ignored.
    if (const auto base = variable("XDG_CACHE_HOME"); base.is_absolute())
        return base / "terravox";
    if (const auto home = variable("HOME"); home.is_absolute())
        return home / ".cache" / "terravox";
    return {};
}

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
    throw Error("{}: no folder can be made in {}; TMPDIR names another place", attempt,
                in.string());
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
