#pragma once

#include <span>
#include <vector>

#include "voxelserver/grid/patch.hpp"
#include "voxelserver/pointcloud/point.hpp"

namespace terravox::store {

/// Which stretches of a file hold points of which patches: found when a file is decoded for the
/// first time, so that later a part of it can be had by decoding a part of it.
class ChunkIndex {
public:
    struct Chunk {
        pointcloud::PointRange points;
        std::vector<grid::PatchKey> patches;  ///< sorted, each once
    };
    ChunkIndex() = default;
    /// @param chunks by rising points
    explicit ChunkIndex(std::vector<Chunk> chunks) : m_chunks(std::move(chunks)) {}

    /// Which chunks hold points of the rectangle's patches, rising.
    [[nodiscard]] std::vector<std::size_t> over(const grid::PatchRect& rect) const;
    /// Ranges that hold every kept point of the rectangle's patches, sorted and merged; they may
    /// hold others.
    [[nodiscard]] std::vector<pointcloud::PointRange> ranges_over(
        const grid::PatchRect& rect) const;
    [[nodiscard]] std::span<const Chunk> chunks() const noexcept { return m_chunks; }

private:
    std::vector<Chunk> m_chunks;
};

}  // namespace terravox::store
