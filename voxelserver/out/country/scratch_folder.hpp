#pragma once

#include <filesystem>
#include <system_error>
#include <utility>

namespace terravox::country {

/// A folder of a plan for what is needed for a while only; it is removed in the end.
class ScratchFolder {
public:
    /// @param path need not exist
    explicit ScratchFolder(std::filesystem::path path) : m_path(std::move(path)) {}
    ~ScratchFolder() {
        std::error_code ignored;
        std::filesystem::remove_all(m_path, ignored);
    }
    ScratchFolder(const ScratchFolder&) = delete;
    ScratchFolder& operator=(const ScratchFolder&) = delete;

    [[nodiscard]] const std::filesystem::path& path() const noexcept { return m_path; }

private:
    const std::filesystem::path m_path;
};

}  // namespace terravox::country
