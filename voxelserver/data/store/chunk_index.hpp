#pragma once

#include <span>
#include <vector>

#include "voxelserver/data/grid/patch.hpp"
#include "voxelserver/data/pointcloud/point.hpp"

namespace terravox::store {

/// Maps chunks of a file to the patches that their points lie in: built when a file is decoded for
/// the first time, so that later only the required part needs to be decoded.
class ChunkIndex {
public:
    struct Chunk {
        pointcloud::PointRange points;
        std::vector<grid::PatchKey> patches;  ///< sorted, without duplicates
    };
    ChunkIndex() = default;
    /// @param chunks in ascending order of points
    explicit ChunkIndex(std::vector<Chunk> chunks) : m_chunks(std::move(chunks)) {}

    /// The chunks that hold points of the rectangle's patches, ascending.
    [[nodiscard]] std::vector<std::size_t> over(const grid::PatchRect& rect) const;
    /// Ranges that contain every kept point of the rectangle's patches, sorted and merged; they may
    /// contain others.
    [[nodiscard]] std::vector<pointcloud::PointRange> ranges_over(
        const grid::PatchRect& rect) const;
    [[nodiscard]] std::span<const Chunk> chunks() const noexcept { return m_chunks; }

private:
    std::vector<Chunk> m_chunks;
};

}  // namespace terravox::store
