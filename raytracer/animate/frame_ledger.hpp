#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>

namespace terravox::animate {

/// Which frames are done, and of which scenes: a text file with a line for each, so that a run that
/// was cut off goes on, and frames whose scene has changed since are made anew. Not thread-safe,
/// but several processes, on several machines too, may add to one file: each line is appended under
/// a lock (flock, which network file systems know; one that does not must append whole lines). A
/// reader sees what was there when it opened the file.
class FrameLedger {
public:
    /// Reads what is there; lines that cannot be understood (cut off, damaged) count for nothing.
    /// @throws Error when it cannot be read
    explicit FrameLedger(std::filesystem::path file);
    [[nodiscard]] bool is_done(int frame, std::uint64_t fingerprint) const;
    /// On the disk when this returns. @throws Error
    void add(int frame, std::uint64_t fingerprint);

private:
    std::filesystem::path m_file;
    std::map<int, std::uint64_t> m_done;
};

/// A number for a text. Ref: Fowler, Noll & Vo, FNV-1a, 64 bit.
[[nodiscard]] std::uint64_t fingerprint_of(const std::string& text) noexcept;

}  // namespace terravox::animate
