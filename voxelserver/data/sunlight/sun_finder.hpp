#pragma once

#include <optional>
#include <span>

#include "voxelserver/data/sunlight/sunlit.hpp"

namespace terravox::sunlight {

/// The sun that explains a photograph best.
struct SunEstimate {
    Sun sun;
    /// Correlation of the logarithm of the photograph's brightness with that of the light which the
    /// surface would receive, both relative to their means in tiles of 12 m and one kind: [-1, 1].
    double correlation = 0;
    /// By how much the correlation exceeds that of the best sun elsewhere (25 degrees away or
    /// more), over the correlation: [0, 1].
    double margin = 0;
};

/// Searches all azimuths, and altitudes from 12 to 75 degrees, coarse to fine. The result depends
/// on the scenes and their order only. Takes about 10 microseconds a cell.
/// @param scenes parts of one photograph, without gaps (fill_gaps)
/// @return nullopt where fewer than 500 cells can be compared
[[nodiscard]] std::optional<SunEstimate> find_sun(std::span<const Scene> scenes);

/// Whether an estimate is good enough to take shadows away by it. False estimates in surveys
/// without shadows reach a correlation of 0.1.
[[nodiscard]] bool is_certain(const SunEstimate& estimate) noexcept;

}  // namespace terravox::sunlight
