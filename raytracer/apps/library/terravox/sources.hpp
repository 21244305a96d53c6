#pragma once

#include <terravox/api.hpp>
#include <terravox/place.hpp>

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace terravox {

/// A voxel of a world of one's own.
struct Voxel {
    std::uint8_t material = 0;      ///< number of terravox::materials(); 0: air
    std::uint8_t source_class = 0;  ///< any number that is to be kept with it
    bool has_colour = false;
    std::array<std::uint8_t, 3> rgb{};  ///< sRGB, with has_colour
};

/// A world of one's own: made box by box, when and where it is looked at. Called from several
/// threads at once. The same box must have the same voxels at any time.
class TERRAVOX_API VoxelSource {
public:
    static constexpr std::int32_t kWidth = 64;    ///< of a box, along x and z
    static constexpr std::int32_t kHeight = 256;  ///< along y

    VoxelSource() = default;
    VoxelSource(const VoxelSource&) = delete;
    VoxelSource& operator=(const VoxelSource&) = delete;
    virtual ~VoxelSource();

    /// Everything solid is within `block` (level 0); title, voxel_m and crs are used, too. Called
    /// once.
    [[nodiscard]] virtual WorldInfo info() const = 0;
    /// Fills a box of level 0. Coarser levels are made of these.
    /// @param corner lowest coordinates of the box: multiples of kWidth and kHeight
    /// @param voxels all air; the voxel (x, y, z) from the corner is number
    /// (y * kWidth + z) * kWidth + x
    /// @return whether anything was set
    /// @throws anything: the box is a hole then
    virtual bool fill(const std::array<std::int32_t, 3>& corner, std::span<Voxel> voxels) = 0;
};

/// A point of a laser scan, or of photogrammetry.
struct Point {
    double x = 0;                     ///< easting
    double y = 0;                     ///< northing
    double z = 0;                     ///< height
    std::uint8_t classification = 1;  ///< of OpenOptions::classes; 1: not classified
    std::uint8_t return_number = 1;   ///< [1, 15]
    std::uint8_t return_count = 1;    ///< [1, 15]
    std::uint16_t intensity = 0;
    std::array<std::uint16_t, 3> rgb{};  ///< all 0: none
};

/// Points of one's own, which are voxelized like those of a LAZ file.
class TERRAVOX_API PointSource {
public:
    PointSource() = default;
    PointSource(const PointSource&) = delete;
    PointSource& operator=(const PointSource&) = delete;
    virtual ~PointSource();

    /// The CRS of the points: "EPSG:3794", WKT, or a PROJ string.
    [[nodiscard]] virtual std::string crs() const = 0;
    /// Replaces the contents of `batch` by the next points, in any order and of any number.
    /// @return false: there are no more
    virtual bool next(std::vector<Point>& batch) = 0;
};

}  // namespace terravox
