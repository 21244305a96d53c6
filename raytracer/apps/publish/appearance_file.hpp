#pragma once

#include <string>

#include "raytracer/core/material/material_file.hpp"

namespace terravox::publish {

/// The air of a place, as in Scene::Sky.
struct AirOptions {
    double turbidity = 2.5;     ///< [1, 20]
    double place_height_m = 0;  ///< of the world's lowest voxel above the sea, [0, 10000]
};

/// What the web viewer needs of materials and the sky: `appearance.bin` (docs/formats/site.md).
/// Materials with their drawings and windows as MaterialTable has them; the clear sky for several
/// altitudes of the sun as Dome has it, on a coarser grid; sunlight, haze, and the night's glow.
/// Compressed as gzip, which browsers unpack.
/// A pure function of its arguments. Takes about a second: the sky is computed once for each
/// altitude.
[[nodiscard]] std::string appearance_file(const material::MaterialAppearances& appearances,
                                          const AirOptions& air);

}  // namespace terravox::publish
