#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "voxelserver/pointcloud/file_bytes.hpp"

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

/// A value that each vertex has.
struct Property {
    std::string name;  ///< as in the file
    Scalar type = Scalar::kFloat32;
    std::uint32_t offset = 0;  ///< byte within the record of a vertex; binary files only
};

/// What is read of a vertex, in this order.
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
    /// Which property holds a field: the first of its names (docs/formats/point-clouds.md). x, y
    /// and z are there, and colours all or none.
    std::array<std::optional<std::size_t>, kFields> fields;
    std::uint32_t record_bytes = 0;  ///< of one vertex; 0 for text
    std::uint64_t data_at = 0;       ///< byte of the first vertex
    std::string crs;                 ///< what a comment says after "crs"; empty when none does

    [[nodiscard]] bool has_colour() const noexcept { return fields[kRed].has_value(); }
};

/// Reads no more than 64 KiB.
/// @throws Error naming the file and the line that cannot be: a header without end, another
/// version, a vertex with lists or without coordinates, a mesh, more vertices than the file holds
[[nodiscard]] Header read_header(const pointcloud::FileBytes& file);

}  // namespace terravox::ply
