#pragma once

#include <cstdint>

#include "voxelserver/out/export/core/job.hpp"

namespace terravox::exports {

enum class MeshFormat : std::uint8_t {
    /// glTF 2.0 in one binary file: y up, metres; a primitive for each material, colours as vertex
    /// colours.
    kGlb,
    /// Stanford triangles, binary: z up, metres, four-sided faces; colour and material at the
    /// vertices.
    kPly,
};

struct MeshOptions {
    /// Combine adjacent faces of one material and one colour. Their edges then end within edges of
    /// others (T-junctions): closed to the eye, but programs that need two faces at each edge need
    /// it off.
    bool merge = true;
    /// Steps of each colour channel, 2 to 255, or 0 for colours as they are: fewer steps, larger
    /// faces.
    int colour_steps = 0;
    /// Maximum size of a glTF file; never more than these 4 GiB, as its lengths have 32 bits.
    std::uint64_t max_glb_bytes = 0xFFFF'FFFFu;
};

/// Writes the visible faces of a part: towards air, and towards see-through voxels of another
/// material. Everything outside the part counts as air, so a solid part is closed. Coordinates are
/// metres from origin_of(part). Streams: memory does not grow with the part. The bytes do not
/// depend on the number of threads.
/// @throws UsageError for options out of range; Error when nothing is solid, the file would become
/// too large, or cannot be written
void write_mesh(Job& job, MeshFormat format, const MeshOptions& options = {});

}  // namespace terravox::exports
