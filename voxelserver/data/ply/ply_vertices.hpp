#pragma once

#include <cstdint>
#include <memory>

#include "voxelserver/data/ply/ply_header.hpp"
#include "voxelserver/data/pointcloud/file_bytes.hpp"
#include "voxelserver/data/pointcloud/point.hpp"

namespace terravox::ply {

/// Reads the vertices of a file sequentially. Memory use does not depend on their number. For use
/// by one thread.
class VertexReader {
public:
    virtual ~VertexReader() = default;
    VertexReader(const VertexReader&) = delete;
    VertexReader& operator=(const VertexReader&) = delete;

    /// Makes `vertex` the number of the next vertex to be read.
    /// @param byte offset at which a vertex begins
    /// @param number the number of that vertex, at most `vertex`
    virtual void seek(std::uint64_t byte, std::uint64_t number, std::uint64_t vertex) = 0;
    /// Offset of the next vertex, bytes.
    [[nodiscard]] virtual std::uint64_t at_byte() const = 0;
    /// @throws Error naming the vertex and the value: unexpected end of file, a line of text with
    /// too few or too many numbers, a coordinate that is not finite, a class or a colour out of
    /// range
    virtual void next(pointcloud::Point& to) = 0;

protected:
    VertexReader() = default;
};

/// Opens a reader positioned at the first vertex.
/// @param file, header  must outlive the reader
[[nodiscard]] std::unique_ptr<VertexReader> open_vertices(const pointcloud::FileBytes& file,
                                                          const Header& header);

}  // namespace terravox::ply
