#pragma once

#include <cstdint>
#include <memory>

#include "voxelserver/ply/ply_header.hpp"
#include "voxelserver/pointcloud/file_bytes.hpp"
#include "voxelserver/pointcloud/point.hpp"

namespace terravox::ply {

/// Reads the vertices of a file one after the other. Memory does not grow with their number. For
/// one thread.
class VertexReader {
public:
    virtual ~VertexReader() = default;
    VertexReader(const VertexReader&) = delete;
    VertexReader& operator=(const VertexReader&) = delete;

    /// The next vertex is the one of this number.
    /// @param byte where a vertex begins @param number its number, at most `vertex`
    virtual void seek(std::uint64_t byte, std::uint64_t number, std::uint64_t vertex) = 0;
    /// Where the next vertex begins.
    [[nodiscard]] virtual std::uint64_t at_byte() const = 0;
    /// @throws Error naming the vertex and the value: the file ends, a line of text with too few or
    /// too many numbers, a coordinate that is not finite, a class or a colour out of its range
    virtual void next(pointcloud::Point& to) = 0;

protected:
    VertexReader() = default;
};

/// @param file and header outlive the reader, which begins at the first vertex
[[nodiscard]] std::unique_ptr<VertexReader> open_vertices(const pointcloud::FileBytes& file,
                                                          const Header& header);

}  // namespace terravox::ply
