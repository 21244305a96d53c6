#pragma once

#include <cstdint>

#include "voxelserver/export/core/job.hpp"

namespace terravox::exports {

struct VoxOptions {
    std::uint64_t max_bytes = 0x7FFF'FFFFu;  ///< of the file; never more than these 2 GiB, for its
                                             ///< lengths are signed numbers of 32 bits
};

/// MagicaVoxel's format, version 200: the voxels of a part that can be seen, in models of up to 256
/// x 256 x 256 under a scene graph that puts them in their places; x east, y north, z up, from
/// origin_of(part). 255 colours, chosen from all of the part; water, glass and ice are _glass, lava
/// and lamps _emit. Reads the part once: voxels are spooled beside the file (8 bytes each) until
/// the colours are chosen. The bytes do not depend on the number of threads. MagicaVoxel itself
/// shows no more than 2000 x 2000 x 1000 voxels: larger parts are written, with a warning.
/// @throws Error when nothing is to be seen, the file would become too large (then nothing is
/// written), or cannot be written
void write_vox(Job& job, const VoxOptions& options = {});

}  // namespace terravox::exports
