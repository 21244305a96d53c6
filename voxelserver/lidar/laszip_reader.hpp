#pragma once

#include <laszip/laszip_api.h>

#include <cstdint>
#include <filesystem>

namespace terravox::lidar {

/// Which fields of formats 6-10 a reader decompresses; coordinates, returns, classes and flags
/// always. Older formats have no choice.
struct WantedFields {
    bool colour = true;
    bool near_infrared = true;
};

/// An open reader of LASzip for a file that check_las_header() has passed; closes itself. For one
/// thread. LASzip trusts what it reads: never open a file unchecked.
class LaszipReader {
public:
    /// @throws Error naming the file and LASzip's reason
    LaszipReader(const std::filesystem::path& path, WantedFields fields);
    ~LaszipReader();
    LaszipReader(const LaszipReader&) = delete;
    LaszipReader& operator=(const LaszipReader&) = delete;

    /// The next point read is this one. Decodes the points of its chunk before it. @throws Error as
    /// above
    void seek(std::uint64_t point);
    /// Decodes one point into point(). @throws Error as above
    void next() { check(laszip_read_point(m_reader)); }
    [[nodiscard]] const laszip_header_struct& header() const noexcept { return *m_header; }
    [[nodiscard]] const laszip_point_struct& point() const noexcept { return *m_point; }

private:
    void check(laszip_I32 failed) const {
        if (failed != 0) [[unlikely]]
            fail();
    }
    [[noreturn]] void fail() const;
    void close() noexcept;

    std::filesystem::path m_path;
    laszip_POINTER m_reader = nullptr;
    laszip_header_struct* m_header = nullptr;
    laszip_point_struct* m_point = nullptr;
    bool m_open = false;
};

}  // namespace terravox::lidar
