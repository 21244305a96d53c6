#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <set>
#include <string>

namespace terravox::convert {

/// What of a conversion into many files is done, so that one that was cut off goes on where it was: a text file with one name a line, below a line
/// that says what is being converted. One whose first line says something else belongs to another conversion, and is begun anew.
/// A name is added only when its file lies whole under its name. Thread-safe.
class Journal {
public:
    /// @param what names the conversion: two that are alike in everything that shapes their files have the same; no line breaks
    /// @throws Error when it cannot be written
    Journal(std::filesystem::path file, const std::string& what);

    [[nodiscard]] bool has(const std::string& name) const;
    /// @param voxels that went into the file, for the report of a run that goes on
    void add(const std::string& name, std::uint64_t voxels);
    /// Sum over what was there when the journal was opened.
    [[nodiscard]] std::uint64_t voxels_before() const noexcept { return m_voxels_before; }
    [[nodiscard]] std::size_t files_before() const noexcept { return m_files_before; }
    void remove();  ///< all is done: the file goes

private:
    const std::filesystem::path m_path;
    mutable std::mutex m_mutex;
    std::set<std::string> m_names;
    std::uint64_t m_voxels_before = 0;
    std::size_t m_files_before = 0;
    std::ofstream m_out;
};

}  // namespace terravox::convert
