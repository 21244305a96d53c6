#pragma once

#include "voxelserver/make/voxelize/world/input_fingerprints.hpp"

namespace terravox::imagery {
class Orthophotos;
}  // namespace terravox::imagery

namespace terravox::voxelize {

struct Sources;

/// InputFingerprints::everywhere of an opened world.
[[nodiscard]] voxel::Fingerprint fingerprint_everywhere(const Sources& sources,
                                                        const ClassTable& classes,
                                                        const Settings& settings, int cell_voxels);

/// The fingerprints of an opened world.
/// @param images nullptr = none
[[nodiscard]] InputFingerprints fingerprints_of(const Sources& sources,
                                                const imagery::Orthophotos* images,
                                                const ClassTable& classes, const Settings& settings,
                                                int cell_voxels);

}  // namespace terravox::voxelize
