#pragma once

#include <filesystem>
#include <string>

namespace terravox::util {

/// A new folder in that of the system for temporary files (TMPDIR), readable by this user alone. It
/// is removed with the object, and by the next one of any process of this user where the process
/// was killed; an empty path is none. Its process holds a lock on it (flock), by which the others
/// know that it lives.
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
