#pragma once

#include <laszip/laszip_api.h>

#include <cstdint>
#include <filesystem>
#include <string>

namespace terravox::lidar {

/// The optional fields of formats 6-10 that a reader decompresses; coordinates, returns, classes
/// and flags are always decompressed. Older formats cannot be decompressed selectively.
struct WantedFields {
    bool colour = true;
    bool near_infrared = true;
    bool echoes = true;  ///< intensity and flight line
    bool all = false;    ///< every field there is
};

/// LASzip's last message as one line without a full stop.
[[nodiscard]] std::string laszip_message(laszip_POINTER laszip);

/// RAII wrapper of a LASzip reader for a file that has passed check_las_header(). For use by one
/// thread. LASzip trusts its input: never open an unchecked file.
class LaszipReader {
public:
    /// @throws Error naming the file and LASzip's reason
    LaszipReader(const std::filesystem::path& path, WantedFields fields);
    ~LaszipReader();
    LaszipReader(const LaszipReader&) = delete;
    LaszipReader& operator=(const LaszipReader&) = delete;

    /// Makes this the next point to be read. Decodes the preceding points of its chunk.
    /// @throws Error as above
    void seek(std::uint64_t point);
    /// Decodes one point into point().
    /// @throws Error as above
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
