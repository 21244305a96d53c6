#include "common/util/files.hpp"

#include <fcntl.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>
#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <string>
#include <unordered_map>
#include <utility>

#include "common/util/error.hpp"
#include "common/util/process.hpp"
#include "common/util/text.hpp"

namespace terravox::util {

namespace fs = std::filesystem;

namespace {

/// A key that identifies a file under any of its names: "./a", a link to it and a hard link have
/// the same.
std::string make_identity(const fs::path& file) {
    struct stat facts{};
    // Size and time in addition to the inode number: on some network file systems these numbers are
    // not unique, and no file must be dropped because of that.
    if (::stat(file.c_str(), &facts) == 0 && facts.st_ino != 0) {
        std::string out;
        for (const auto part :
             {static_cast<long long>(facts.st_dev), static_cast<long long>(facts.st_ino),
              static_cast<long long>(facts.st_size), static_cast<long long>(facts.st_mtim.tv_sec),
              static_cast<long long>(facts.st_mtim.tv_nsec)})
            out += std::to_string(part) + "|";
        return out;
    }
    std::error_code failed;
    const fs::path canonical = fs::weakly_canonical(file, failed);
    return failed ? file.string() : canonical.string();
}

}  // namespace

std::vector<fs::path> expand_folders(const std::vector<fs::path>& paths,
                                     std::initializer_list<std::string_view> endings,
                                     std::string_view what) {
    return expand_folders(paths, std::span(endings.begin(), endings.size()), what,
                          [](const fs::path& /*file*/) { return true; });
}

std::vector<fs::path> expand_folders(const std::vector<fs::path>& paths,
                                     std::span<const std::string_view> endings,
                                     std::string_view what,
                                     const std::function<bool(const fs::path&)>& belongs) {
    std::vector<fs::path> out;
    std::unordered_map<std::string, std::size_t> index_of;
    const auto add = [&](const fs::path& file) {
        const auto [known, fresh] = index_of.try_emplace(make_identity(file), out.size());
        if (fresh)
            out.push_back(file);
        else
            out[known->second] = std::min(out[known->second], file);
    };
    for (const fs::path& path : paths) {
        std::error_code failed;
        if (!fs::exists(path, failed))
            throw UsageError("open the {} {}: no such file or folder", what, path.string());
        if (!fs::is_directory(path, failed)) {
            add(path);
            continue;
        }
        std::vector<fs::path> inside;
        for (const auto& entry : fs::directory_iterator(path, failed)) {
            const std::string ending = lower_extension(entry.path());
            // Names that begin with a dot are files still being written.
            if (entry.path().filename().string().front() != '.' &&
                std::find(endings.begin(), endings.end(), ending) != endings.end() &&
                belongs(entry.path()))
                inside.push_back(entry.path());
        }
        if (failed)
            throw Error("open the {} in {}: {}", what, path.string(), failed.message());
        if (inside.empty()) {
            std::string allowed;
            for (const auto& e : endings)
                allowed += (allowed.empty() ? "" : " ") + std::string(e);
            throw UsageError("open the {} in {}: the folder holds none of {}", what, path.string(),
                             allowed);
        }
        std::sort(inside.begin(), inside.end());
        for (const fs::path& file : inside)
            add(file);
    }
    return out;
}

void Descriptor::close() noexcept {
    if (m_fd >= 0)
        ::close(std::exchange(m_fd, -1));
}

Pipe open_pipe(const std::string& attempt) {
    std::array<int, 2> ends{};
    if (::pipe2(ends.data(), O_CLOEXEC) != 0)
        throw Error(attempt + ": " + std::strerror(errno));
    return {Descriptor(ends[0]), Descriptor(ends[1])};
}

namespace {

/// What was read of a file, and why it was not all that was wanted; empty: it was.
struct ReadFile {
    std::string text;
    std::string fault;
};

ReadFile read_first(const fs::path& file, std::size_t bytes) {
    struct stat facts{};
    if (::stat(file.c_str(), &facts) != 0)
        return {{}, errno == ENOENT || errno == ENOTDIR ? "no such file" : std::strerror(errno)};
    if (!S_ISREG(facts.st_mode))
        return {{}, "not a plain file"};
    const Descriptor in(::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
    if (in.get() < 0)
        return {{}, std::strerror(errno)};
    // Reads in parts: a file may grow, or report no size (/proc), and no memory is allocated for
    // bytes that are not there.
    ReadFile out;
    std::size_t used = 0;
    for (ssize_t count = 1; count != 0 && used < bytes;) {
        constexpr std::size_t kPart_bytes = std::size_t{1} << 16;
        if (used == out.text.size())
            out.text.resize(std::min(bytes, std::max(2 * used, kPart_bytes)));
        count = ::read(in.get(), out.text.data() + used, out.text.size() - used);
        if (count > 0)
            used += static_cast<std::size_t>(count);
        else if (count < 0 && errno != EINTR) {
            out.fault = std::strerror(errno);
            break;
        }
    }
    out.text.resize(used);
    return out;
}

/// Other programs' texts may begin with the mark of UTF-8, which is no part of them.
std::string without_mark(std::string text) {
    constexpr std::string_view kMark = "\xEF\xBB\xBF";
    return text.starts_with(kMark) ? text.substr(kMark.size()) : std::move(text);
}

std::string size_text(std::size_t bytes) {
    constexpr std::size_t kMib = std::size_t{1} << 20;
    return bytes % kMib == 0 ? std::to_string(bytes / kMib) + " MiB"
                             : std::to_string(bytes) + " bytes";
}

}  // namespace

std::string read_text(const fs::path& file, std::size_t limit_bytes, const FailToRead& fail) {
    ReadFile out = read_first(file, limit_bytes + 1);
    if (out.text.size() > limit_bytes)
        fail("more than " + size_text(limit_bytes) + "; allowed: up to that");
    if (!out.fault.empty())
        fail(out.fault);
    return without_mark(std::move(out.text));
}

std::string read_text(const fs::path& file, std::size_t limit_bytes, const std::string& attempt) {
    return read_text(file, limit_bytes,
                     [&](const std::string& what) { throw Error(attempt + ": " + what); });
}

std::optional<std::string> try_read_text(const fs::path& file, std::size_t limit_bytes) {
    ReadFile out = read_first(file, limit_bytes + 1);
    if (out.text.size() > limit_bytes || !out.fault.empty())
        return std::nullopt;
    return without_mark(std::move(out.text));
}

std::string read_start(const fs::path& file, std::size_t bytes) {
    return read_first(file, bytes).text;
}

int open_to_write(const fs::path& file, int flags, unsigned mode, const std::string& attempt) {
    // Opening a pipe would wait for its reader.
    const int fd = ::open(file.c_str(), flags | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK, mode);
    const int why = errno;
    std::error_code ignored;
    if (fd < 0 && fs::is_symlink(file, ignored))
        throw Error(
            "{}: {} is a symbolic link, which is not followed; allowed: a plain file, or none",
            attempt, file.string());
    if (fd < 0)
        throw Error(attempt + ": " + std::strerror(why));
    struct stat facts{};
    if (::fstat(fd, &facts) == 0 && S_ISREG(facts.st_mode))
        return fd;
    ::close(fd);
    throw Error("{}: {} is not a plain file; allowed: one, or none", attempt, file.string());
}

int open_unnamed(const fs::path& near, const std::string& attempt) {
    const fs::path folder = near.parent_path().empty() ? fs::path(".") : near.parent_path();
    std::string name = (folder / ("." + near.filename().string() + ".spool-XXXXXX")).string();
    const int fd = ::mkostemp(name.data(), O_CLOEXEC);
    if (fd < 0)
        throw Error("{}: no file can be made in {}: {}", attempt, folder.string(),
                    std::strerror(errno));
    ::unlink(name.c_str());
    return fd;
}

bool is_named(int fd, const fs::path& name) noexcept {
    struct stat open{};
    struct stat named{};
    return ::fstat(fd, &open) == 0 && ::stat(name.c_str(), &named) == 0 &&
           open.st_dev == named.st_dev && open.st_ino == named.st_ino;
}

int write_all(int fd, std::span<const std::byte> bytes) noexcept {
    while (!bytes.empty()) {
        const ssize_t written = ::write(fd, bytes.data(), bytes.size());
        if (written < 0 && errno == EINTR)
            continue;
        if (written < 0)
            return errno;
        bytes = bytes.subspan(static_cast<std::size_t>(written));
    }
    return 0;
}

void raise_open_file_limit() noexcept {
    rlimit limit{};
    if (::getrlimit(RLIMIT_NOFILE, &limit) != 0 || limit.rlim_cur == limit.rlim_max)
        return;
    limit.rlim_cur = limit.rlim_max;
    // On failure the limit is unchanged, and so are the limits on connections that depend on it.
    (void)::setrlimit(RLIMIT_NOFILE, &limit);
}

std::shared_ptr<const MappedFile> MappedFile::open(const std::filesystem::path& path) {
    const auto fail = [&](const char* what) {
        return Error("map the file {}: {}", path.string(), what);
    };
    // Opening a pipe would block until it has a writer.
    const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (file < 0) {
        if (errno == ENOENT || errno == ENOTDIR)
            return nullptr;
        throw fail(std::strerror(errno));
    }
    struct stat facts{};
    const bool known = ::fstat(file, &facts) == 0 && S_ISREG(facts.st_mode);
    const auto size = static_cast<std::size_t>(known ? facts.st_size : 0);
    void* data =
        known && size > 0 ? ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, file, 0) : nullptr;
    const int code = errno;
    ::close(file);
    if (!known)
        throw fail("not a plain file");
    if (data == MAP_FAILED)
        throw fail(std::strerror(code));
    return std::shared_ptr<const MappedFile>(
        new MappedFile(static_cast<const std::byte*>(data), size));
}

MappedFile::~MappedFile() {
    if (m_size > 0)
        ::munmap(const_cast<std::byte*>(m_data), m_size);
}

bool readable(std::span<const std::byte> part) noexcept {
    if (part.empty())
        return true;
#ifdef MADV_POPULATE_READ
    static const auto page = static_cast<std::uintptr_t>(::sysconf(_SC_PAGESIZE));
    const auto begin = reinterpret_cast<std::uintptr_t>(part.data()) / page * page;
    const auto end = reinterpret_cast<std::uintptr_t>(part.data() + part.size());
    // The check uses the mapping itself, so that no file needs to stay open for it. Pages that were
    // read are kept, so an interrupted call makes progress when it is repeated.
    int rc = -1;
    do
        rc = ::madvise(reinterpret_cast<void*>(begin), end - begin, MADV_POPULATE_READ);
    while (rc != 0 && (errno == EINTR || errno == EAGAIN));
    return rc == 0 || (errno != EFAULT && errno != EHWPOISON);
#else
    return true;
#endif
}

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
    return Error("lock {}: {}", file.string(), std::strerror(errno));
}

/// Writes the process and the machine into the file; only messages show it, so a full disk does not
/// matter.
void sign(int fd) {
    const std::string line = "process " + std::to_string(::getpid()) + " of " + host_name() + "\n";
    if (::ftruncate(fd, 0) != 0)
        return;
    [[maybe_unused]] const auto written = ::pwrite(fd, line.data(), line.size(), 0);
}

}  // namespace

std::optional<FileLock> FileLock::try_take(const std::filesystem::path& file) {
    for (;;) {
        FileLock out(open_to_write(file, O_RDWR | O_CREAT, 0644, "lock " + file.string()));
        struct flock lock = whole_file();
        if (::fcntl(out.m_file.get(), F_OFD_SETLK, &lock) != 0) {
            if (errno == EAGAIN || errno == EACCES)
                return std::nullopt;
            throw failed(file);
        }
        // Else the process that had the lock has removed the file meanwhile, and a third one may
        // lock the next file of that name.
        if (is_named(out.m_file.get(), file)) {
            sign(out.m_file.get());
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

}  // namespace terravox::util
