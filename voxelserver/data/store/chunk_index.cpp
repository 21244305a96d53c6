#include "voxelserver/data/store/chunk_index.hpp"

#include <algorithm>

namespace terravox::store {

std::vector<std::size_t> ChunkIndex::over(const grid::PatchRect& rect) const {
    std::vector<std::size_t> out;
    for (std::size_t i = 0; i < m_chunks.size(); ++i)
        if (std::any_of(m_chunks[i].patches.begin(), m_chunks[i].patches.end(),
                        [&](grid::PatchKey k) { return rect.contains(k); }))
            out.push_back(i);
    return out;
}

std::vector<pointcloud::PointRange> ChunkIndex::ranges_over(const grid::PatchRect& rect) const {
    std::vector<pointcloud::PointRange> out;
    for (const std::size_t i : over(rect)) {
        if (!out.empty() && out.back().end == m_chunks[i].points.begin)
            out.back().end = m_chunks[i].points.end;
        else
            out.push_back(m_chunks[i].points);
    }
    return out;
}

}  // namespace terravox::store
