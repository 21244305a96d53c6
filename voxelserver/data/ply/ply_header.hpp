#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "voxelserver/data/pointcloud/file_bytes.hpp"

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
[[nodiscard]] std::uint32_t bytes_of(Scalar type) noexcept;

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

}  // namespace terravox::ply
