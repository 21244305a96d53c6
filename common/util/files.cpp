#include "common/util/files.hpp"

#include <fcntl.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <string>
#include <unordered_map>

#include "common/util/error.hpp"
#include "common/util/letter_case.hpp"

namespace terravox::util {

namespace fs = std::filesystem;

namespace {

/// A key that identifies a file under any of its names: "./a", a link to it and a hard link have
/// the same.
std::string identity_of(const fs::path& file) {
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
        const auto [known, fresh] = index_of.try_emplace(identity_of(file), out.size());
        if (fresh)
            out.push_back(file);
        else
            out[known->second] = std::min(out[known->second], file);
    };
    for (const fs::path& path : paths) {
        std::error_code failed;
        if (!fs::exists(path, failed))
            throw UsageError("open the " + std::string(what) + " " + path.string() +
                             ": no such file or folder");
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
            throw Error("open the " + std::string(what) + " in " + path.string() + ": " +
                        failed.message());
        if (inside.empty()) {
            std::string allowed;
            for (const auto& e : endings)
                allowed += (allowed.empty() ? "" : " ") + std::string(e);
            throw UsageError("open the " + std::string(what) + " in " + path.string() +
                             ": the folder holds none of " + allowed);
        }
        std::sort(inside.begin(), inside.end());
        for (const fs::path& file : inside)
            add(file);
    }
    return out;
}

int open_to_write(const fs::path& file, int flags, unsigned mode, const std::string& attempt) {
    // Opening a pipe would wait for its reader.
    const int fd = ::open(file.c_str(), flags | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK, mode);
    const int why = errno;
    std::error_code ignored;
    if (fd < 0 && fs::is_symlink(file, ignored))
        throw Error(attempt + ": " + file.string() +
                    " is a symbolic link, which is not followed; allowed: a plain file, or none");
    if (fd < 0)
        throw Error(attempt + ": " + std::strerror(why));
    struct stat facts{};
    if (::fstat(fd, &facts) == 0 && S_ISREG(facts.st_mode))
        return fd;
    ::close(fd);
    throw Error(attempt + ": " + file.string() + " is not a plain file; allowed: one, or none");
}

int open_unnamed(const fs::path& near, const std::string& attempt) {
    const fs::path folder = near.parent_path().empty() ? fs::path(".") : near.parent_path();
    std::string name = (folder / ("." + near.filename().string() + ".spool-XXXXXX")).string();
    const int fd = ::mkostemp(name.data(), O_CLOEXEC);
    if (fd < 0)
        throw Error(attempt + ": no file can be made in " + folder.string() + ": " +
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

}  // namespace terravox::util
