#pragma once

#include <cstdint>

namespace terravox::procedural {

/// Parameters of a generated world: equal settings give equal voxels, on every machine. Heights and
/// lengths are voxels of level 0.
struct Settings {
    std::uint64_t seed = 1;
    /// The sea's surface is the upper face of voxel water_level - 1; 0 and multiples of large
    /// powers of two are at the same height on all levels; [-4096, 4096]
    int water_level = 0;
    /// Approximate height of the highest summits above the sea; the deepest sea is half as deep;
    /// [8, 4096]
    int world_height = 160;
    /// Octaves of hills and ridges, each twice as fine as the one before; [1, 16]
    int harmonics = 6;
    /// Frequency of the first octave of the hills, 1 / voxels; continents and climates are wider by
    /// fixed ratios; [1e-5, 0.1]
    double frequency = 1.0 / 256;
    /// Height of an octave relative to the one before: 0 smooth, 1 jagged; [0, 1]
    double smoothness = 0.45;
    double voxel_m = 1;  ///< edge of a voxel, metres; (0, 1000]
    bool trees = true;   ///< and bushes, cacti, grass tufts

    friend bool operator==(const Settings&, const Settings&) = default;
};

/// @throws UsageError naming field, value and allowed range
void check(const Settings& settings);

}  // namespace terravox::procedural
