#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "voxelserver/data/pointcloud/file_bytes.hpp"
#include "voxelserver/data/pointcloud/point.hpp"

namespace terravox::ply {

enum class Encoding : std::uint8_t { kAscii, kLittleEndian, kBigEndian };

enum class Scalar : std::uint8_t {
    kInt8,
    kUint8,
    kInt16,
    kUint16,
    kInt32,
    kUint32,
    kFloat32,
    kFloat64
};

/// @return 1, 2, 4 or 8
[[nodiscard]] std::uint32_t measure_bytes(Scalar type) noexcept;

/// A property of each vertex.
struct Property {
    std::string name;  ///< as in the file
    Scalar type = Scalar::kFloat32;
    std::uint32_t offset = 0;  ///< offset within the record of a vertex, bytes; binary files only
};

/// The values read from a vertex, in this order.
enum Field : std::uint8_t {
    kX,
    kY,
    kZ,
    kRed,
    kGreen,
    kBlue,
    kClass,
    kReturnNumber,
    kReturnCount,
    kFields
};

/// The header of a PLY file of points, checked against the file's size.
/// Ref: Turk, "The PLY Polygon File Format", Stanford University, 1994.
struct Header {
    Encoding encoding = Encoding::kAscii;
    std::uint64_t vertex_count = 0;
    std::vector<Property> properties;  ///< of a vertex, in file order
    /// For each field the index of the property that holds it, chosen by name in order of
    /// preference (docs/formats/point-clouds.md). x, y and z are always present; either all colours
    /// are or none.
    std::array<std::optional<std::size_t>, kFields> fields;
    std::uint32_t record_bytes = 0;  ///< size of one vertex; 0 for text files
    std::uint64_t data_at = 0;       ///< offset of the first vertex, bytes
    std::string crs;  ///< the text after "crs" in a comment; empty when there is none

    [[nodiscard]] bool has_colour() const noexcept { return fields[kRed].has_value(); }
};

/// Reads and checks the header; reads at most 64 KiB.
/// @throws Error naming the file and the invalid line: an unterminated header, an unsupported
/// version, a vertex with lists or without coordinates, a mesh, more vertices than the file can
/// hold
[[nodiscard]] Header read_header(const pointcloud::FileBytes& file);

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
