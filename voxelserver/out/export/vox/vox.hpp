#pragma once

#include <cstdint>

#include "voxelserver/out/export/core/job.hpp"

namespace terravox::exports {

struct VoxOptions {
    /// Maximum size of the file; never more than these 2 GiB, as its lengths are signed numbers of
    /// 32 bits.
    std::uint64_t max_bytes = 0x7FFF'FFFFu;
};

/// Writes MagicaVoxel's format, version 200: the visible voxels of a part, in models of up to 256
/// x 256 x 256 under a scene graph that places them; x east, y north, z up, from origin_of(part).
/// 255 colours, chosen for the whole part; water, glass and ice are _glass, lava and lamps _emit.
/// Reads the part once: voxels are spooled in the folder of the file (8 bytes each) until the
/// colours are chosen. The bytes do not depend on the number of threads. MagicaVoxel itself shows
/// no more than 2000 x 2000 x 1000 voxels: larger parts are written, with a warning.
/// @throws Error when nothing is visible, the file would become too large (then nothing is
/// written), or cannot be written
void write_vox(Job& job, const VoxOptions& options = {});

}  // namespace terravox::exports
