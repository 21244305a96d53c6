#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>

namespace terravox::animate {

/// Which frames are done, and of which scenes: a text file with a line for each, so that an
/// interrupted run can continue, and frames whose scene has changed since are rendered anew. Not
/// thread-safe, but several processes, on several machines too, may add to one file: each line is
/// appended under a lock (flock, which network file systems support; one that does not must append
/// whole lines). A reader uses the lines that the file had when it was opened.
class FrameLedger {
public:
    /// Reads the existing lines; lines that cannot be parsed (cut off, damaged) are ignored.
    /// @throws Error when it cannot be read
    explicit FrameLedger(std::filesystem::path file);
    [[nodiscard]] bool is_done(int frame, std::uint64_t fingerprint) const;
    /// Adds a line; it is on the disk when this returns.
    /// @throws Error
    void add(int frame, std::uint64_t fingerprint);

private:
    std::filesystem::path m_file;
    std::map<int, std::uint64_t> m_done;
};

/// A hash of a text. Ref: Fowler, Noll & Vo, FNV-1a, 64 bit.
[[nodiscard]] std::uint64_t fingerprint_of(const std::string& text) noexcept;

}  // namespace terravox::animate
