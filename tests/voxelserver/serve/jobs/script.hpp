#pragma once

#include <filesystem>
#include <fstream>
#include <string>

#include "tests/common/content.hpp"
#include "tests/common/temporary_folder.hpp"

namespace terravox::test {

/// A program in place of the ray tracer.
class Script {
public:
    /// @param body lines of a POSIX shell
    explicit Script(const std::string& body) : m_file(m_folder.path() / "program") {
        std::ofstream(m_file) << "#!/bin/sh\n" << body << "\n";
        std::filesystem::permissions(m_file, std::filesystem::perms::owner_all);
    }
    [[nodiscard]] const std::filesystem::path& file() const noexcept { return m_file; }
    /// A file that the script may write to, and its text.
    [[nodiscard]] std::filesystem::path note() const { return m_folder.path() / "note"; }
    [[nodiscard]] std::string noted() const { return read_content(note()); }

private:
    TemporaryFolder m_folder;
    std::filesystem::path m_file;
};

}  // namespace terravox::test
