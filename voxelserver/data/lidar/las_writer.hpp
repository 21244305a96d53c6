#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

namespace terravox::lidar {

/// One return to write, in the coordinates of the file.
struct LasWritePoint {
    double x = 0;
    double y = 0;
    double z = 0;
    std::uint16_t intensity = 0;
    std::uint8_t return_number = 1, return_count = 1;  ///< [1, 15]; [1, 7] for formats 0-5
    std::uint8_t classification = 1;                   ///< [0, 255]; [0, 31] for formats 0-5
    bool forward_scan = false;                         ///< direction of the scanner's mirror
    bool line_edge = false;                            ///< first or last point of a scan line
    double scan_angle_deg = 0;                         ///< [-180, 180]; [-90, 90] for formats 0-5
    std::uint16_t point_source = 0;                    ///< number of the flight line
    double gps_time_s = 0;  ///< adjusted standard GPS time (minus 1e9); not in format 0 and 2
    std::array<std::uint16_t, 3> rgb{};  ///< formats 2, 3, 7 and 8
};

struct LasWriterOptions {
    int point_format = 6;                              ///< 0-3 (LAS 1.2) or 6-8 (LAS 1.4)
    std::array<double, 3> scale = {0.01, 0.01, 0.01};  ///< above 0
    std::array<double, 3> offset{};
    std::string wkt;  ///< OGC WKT 1 as required by LAS 1.4; empty = no CRS in the file
    std::string generating_software = "Terravox";  ///< truncated to 31 characters
    std::string system_identifier = "Terravox";
    /// 0 = not recorded, so that two runs write the same bytes
    std::uint16_t creation_year = 0;
    std::uint16_t creation_day = 0;
};

/// Writes a LAS or LAZ file (by the extension .laz) point by point; memory use does not depend on
/// the number of points. The file appears under its name at close(), with counts and bounds in its
/// header; without close() nothing is left behind. Not thread-safe; several writers may work at the
/// same time.
class LasWriter {
public:
    /// @throws UsageError for a point format or a scale out of range; Error when the file cannot be
    /// written
    LasWriter(const std::filesystem::path& path, const LasWriterOptions& options);
    ~LasWriter();
    LasWriter(LasWriter&&) noexcept;
    LasWriter& operator=(LasWriter&&) noexcept;

    /// @throws Error when a coordinate does not fit the scale and offset, a field is out of range,
    /// or the disk is full
    void write(const LasWritePoint& point);
    /// Finishes the file; call it once.
    /// @throws Error when the file cannot be finished
    void close();
    [[nodiscard]] std::uint64_t point_count() const noexcept;

private:
    struct State;
    std::unique_ptr<State> m_state;
};

}  // namespace terravox::lidar
