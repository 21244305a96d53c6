#pragma once

#include <filesystem>
#include <string>

namespace terravox::util {

/// A new folder in that of the system for temporary files (TMPDIR), readable by this user alone. It
/// is removed with the object. Where its process was killed, the next process of this user that
/// makes one removes it: a process holds a lock (flock) on its folders, where the file system has
/// locks. An empty path is none.
class TemporaryFolder {
public:
    TemporaryFolder() = default;
    /// @param attempt beginning of the error message: "view"
    /// @throws Error when it cannot be made
    static TemporaryFolder make(const std::string& attempt);
    TemporaryFolder(TemporaryFolder&& other) noexcept;
    TemporaryFolder& operator=(TemporaryFolder&& other) noexcept;
    ~TemporaryFolder();
    [[nodiscard]] const std::filesystem::path& path() const noexcept { return m_path; }
    /// Removes it now. A file that another thread makes meanwhile does not keep it.
    void remove() noexcept;

private:
    std::filesystem::path m_path;
    int m_lock = -1;  ///< descriptor of the folder
};

}  // namespace terravox::util
