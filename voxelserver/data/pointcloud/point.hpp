#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>

namespace terravox::pointcloud {

/// One return, in the coordinates of its file.
struct Point {
    double x = 0, y = 0, z = 0;       ///< finite
    std::uint8_t classification = 0;  ///< 0-255, to be interpreted by a class table
    std::uint8_t return_number = 1;
    std::uint8_t return_count = 1;
    bool withheld = false;
    bool overlap = false;
    std::array<std::uint16_t, 3> rgb{};  ///< 0 when the file has none
    std::uint16_t intensity = 0;         ///< of the echo, of any scale; 0 when the file has none
    std::uint16_t line = 0;              ///< number of the flight line; 0 when the file has none
};

/// A range of point indices of one file, half-open.
struct PointRange {
    std::uint64_t begin = 0;
    std::uint64_t end = 0;
    friend bool operator==(const PointRange&, const PointRange&) = default;
};

/// Receives points in batches of at least 1, in file order; the span is valid during the call only.
using PointBatchSink = std::function<void(std::span<const Point>)>;

}  // namespace terravox::pointcloud
