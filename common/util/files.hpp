#pragma once

#include <filesystem>
#include <functional>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
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

}  // namespace terravox::util
