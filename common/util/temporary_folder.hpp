#pragma once

#include <filesystem>
#include <string>

namespace terravox::util {

/// A new folder in that of the system for temporary files (TMPDIR), readable by this user alone. It
/// is removed with the object; an empty path is none.
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
};

}  // namespace terravox::util
