#pragma once

#include <filesystem>
#include <optional>

#include "common/util/file_lock.hpp"

namespace terravox::publish {

/// The folder of a site while it is written: by one process at a time, and never over files of
/// others. A file with the lock lies in it meanwhile. It stays where the process ends before the
/// folder is a site, and tells the next run whose folder that is.
class SiteFolder {
public:
    /// Makes the folder where it is missing, takes the lock, and removes the unfinished files of
    /// killed runs.
    /// @param input a file that may lie in the folder, as what is published; empty: none
    /// @param overwrite the folder may hold anything
    /// @throws UsageError for a folder that is neither new, empty nor a site, and holds more than
    /// the input; Error when it cannot be made, or another process writes a site there
    SiteFolder(std::filesystem::path folder, const std::filesystem::path& input, bool overwrite);
    /// Removes the file of the lock, unless the folder holds something, and no site yet.
    ~SiteFolder();
    SiteFolder(const SiteFolder&) = delete;
    SiteFolder& operator=(const SiteFolder&) = delete;

    [[nodiscard]] const std::filesystem::path& path() const noexcept { return m_path; }

private:
    void take_lock();
    void remove_unfinished() const;

    const std::filesystem::path m_path;
    const std::filesystem::path m_input;
    std::optional<util::FileLock> m_lock;
};

/// The file of the lock, in the folder of a site.
inline constexpr const char* kSiteLock = ".terravox-publish.lock";

}  // namespace terravox::publish
