#pragma once

#include <cstdint>
#include <filesystem>

namespace terravox::laz {

struct Compressed {
    std::uint64_t points = 0;
    std::uint64_t bytes_before = 0;
    std::uint64_t bytes_after = 0;
};

/// Compresses a LAS file (1.0-1.4, point formats 0-10) losslessly to LAZ: header, variable-length
/// records, points, and the data after the points (extended records, waveforms) with its offsets
/// corrected. The result is read back and compared point by point before it appears under its name;
/// on failure nothing is left there. Memory use does not depend on the size of the file.
/// @throws UsageError when both names are one file; Error for a file that is damaged, already
/// compressed or without points, and when the result cannot be written or differs
[[nodiscard]] Compressed compress(const std::filesystem::path& from,
                                  const std::filesystem::path& to);

}  // namespace terravox::laz
