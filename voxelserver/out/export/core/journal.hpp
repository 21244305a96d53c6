#pragma once

#include <cstdint>
#include <filesystem>
#include <mutex>
#include <set>
#include <string>

namespace terravox::exports {

/// The progress of a conversion into many files, so that an interrupted one can resume: a text file
/// with one name a line, below a line that identifies the conversion. If the first line differs,
/// the journal belongs to another conversion, and is begun anew. A name (without blanks) is added
/// only when its file is complete under its name. Thread-safe.
class Journal {
public:
    /// @param what identifies the conversion: the same for two that are alike in everything that
    /// affects their files; no line breaks
    /// @throws Error when it cannot be written, or another conversion is running there
    Journal(std::filesystem::path file, const std::string& what);
    ~Journal();
    Journal(const Journal&) = delete;
    Journal& operator=(const Journal&) = delete;

    [[nodiscard]] bool has(const std::string& name) const;
    /// @param voxels that were written to the file, for the report of a resumed run
    /// @param end of the bytes written, where everything goes into one file
    void add(const std::string& name, std::uint64_t voxels, std::uint64_t end = 0);
    /// Contents of the journal when it was opened: voxels in all, files, the farthest end.
    [[nodiscard]] std::uint64_t voxels_before() const noexcept { return m_voxels_before; }
    [[nodiscard]] std::size_t files_before() const noexcept { return m_files_before; }
    [[nodiscard]] std::uint64_t end_before() const noexcept { return m_end_before; }
    /// How many files a journal names, of this conversion; 0 where there is none. Locks nothing.
    [[nodiscard]] static std::size_t files_in(const std::filesystem::path& file,
                                              const std::string& what);
    void forget();  ///< discards the earlier entries: begins anew
    void remove();  ///< the conversion is complete: deletes the file

private:
    void open();
    /// @return whether it is of this conversion
    [[nodiscard]] bool read();
    void begin(bool goes_on);
    void append(const std::string& text) const;
    void close() noexcept;
    [[noreturn]] void fail(const std::string& why) const;
    const std::filesystem::path m_path;
    const std::string m_what;
    mutable std::mutex m_mutex;
    std::set<std::string> m_names;
    std::uint64_t m_voxels_before = 0;
    std::uint64_t m_end_before = 0;
    std::size_t m_files_before = 0;
    /// Locked: two conversions to one place would corrupt each other.
    int m_fd = -1;
};

}  // namespace terravox::exports
