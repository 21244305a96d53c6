#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <set>
#include <string>

namespace terravox::exports {

/// What of a conversion into many files is done, so that one that was cut off goes on where it was:
/// a text file with one name a line, below a line that says what is being converted. One whose
/// first line says something else belongs to another conversion, and is begun anew. A name (without
/// blanks) is added only when its file lies whole under its name. Thread-safe.
class Journal {
public:
    /// @param what names the conversion: two that are alike in everything that shapes their files
    /// have the same; no line breaks
    /// @throws Error when it cannot be written, or another conversion is at work there
    Journal(std::filesystem::path file, const std::string& what);
    ~Journal();
    Journal(const Journal&) = delete;
    Journal& operator=(const Journal&) = delete;

    [[nodiscard]] bool has(const std::string& name) const;
    /// @param voxels that went into the file, for the report of a run that goes on @param end of
    /// what was written, where all goes into one file
    void add(const std::string& name, std::uint64_t voxels, std::uint64_t end = 0);
    /// Of what was there when the journal was opened: voxels in all, files, the farthest end.
    [[nodiscard]] std::uint64_t voxels_before() const noexcept { return m_voxels_before; }
    [[nodiscard]] std::size_t files_before() const noexcept { return m_files_before; }
    [[nodiscard]] std::uint64_t end_before() const noexcept { return m_end_before; }
    void forget();  ///< what was there is of no use: begins anew
    void remove();  ///< all is done: the file goes

private:
    void lock();
    void open(bool goes_on);
    const std::filesystem::path m_path;
    const std::string m_what;
    mutable std::mutex m_mutex;
    std::set<std::string> m_names;
    std::uint64_t m_voxels_before = 0, m_end_before = 0;
    std::size_t m_files_before = 0;
    std::ofstream m_out;
    int m_lock =
        -1;  ///< the file again, locked: two conversions to one place would spoil each other
};

}  // namespace terravox::exports
