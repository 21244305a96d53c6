#pragma once

#include <filesystem>
#include <system_error>

#include "common/voxel/archive/archive_writer.hpp"

namespace terravox::voxel::archive {

/// Removes what a writer has written, unless it is released: nothing stays of a call that failed.
class Unfinished {
public:
    /// @param writer whose file nobody else writes
    explicit Unfinished(const ArchiveWriter& writer) : m_file(writer.unfinished_file()) {}
    ~Unfinished() {
        std::error_code ignored;
        if (!m_file.empty())
            std::filesystem::remove(m_file, ignored);
    }
    Unfinished(const Unfinished&) = delete;
    Unfinished& operator=(const Unfinished&) = delete;
    void release() noexcept { m_file.clear(); }

private:
    std::filesystem::path m_file;
};

}  // namespace terravox::voxel::archive
