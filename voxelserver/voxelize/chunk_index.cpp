#include "voxelserver/voxelize/chunk_index.hpp"

#include <algorithm>

namespace terravox::voxelize {

std::vector<lidar::PointRange> ChunkIndex::ranges_over(const PatchRect& rect) const {
    std::vector<lidar::PointRange> out;
    for (const Chunk& chunk : m_chunks) {
        if (std::none_of(chunk.patches.begin(), chunk.patches.end(), [&](PatchKey k) { return rect.contains(k); })) continue;
        if (!out.empty() && out.back().end == chunk.points.begin) out.back().end = chunk.points.end;
        else out.push_back(chunk.points);
    }
    return out;
}

}  // namespace terravox::voxelize
