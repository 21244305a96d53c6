#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <stop_token>

#include "raytracer/analyse/raster/cell_file.hpp"

namespace terravox::analyse {

/// What the values of a band are like. Cells without a value are left out.
struct BandStatistics {
    static constexpr std::size_t kBins = 256;

    std::uint64_t cells = 0;  ///< that have a value; with 0 of them the rest means nothing
    double min = 0;
    double max = 0;
    double mean = 0;
    std::array<std::uint64_t, kBins> bins{};  ///< of equal width, from min to max

    /// The value below which a share of the cells lies, to the width of a bin.
    /// @param share [0, 1]
    [[nodiscard]] double quantile(double share) const noexcept;
};

/// Reads a band twice, block by block, so that it may be larger than memory.
/// @param band its number, from 1
/// @throws Error "interrupted" when stopped, and as CellFile
[[nodiscard]] BandStatistics statistics_of(CellFile& cells, int band, const std::stop_token& stop);

/// How many cells have each number, of a band of categories.
/// @throws as statistics_of()
[[nodiscard]] std::map<int, std::uint64_t> counts_of(CellFile& cells, int band,
                                                     const std::stop_token& stop);

}  // namespace terravox::analyse
