#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <unordered_map>
#include <vector>

#include "voxelserver/lidar/las_file.hpp"
#include "voxelserver/voxelize/class_table.hpp"
#include "voxelserver/voxelize/frame.hpp"

namespace terravox::voxelize {

/// Columns come in patches of 64 x 64, the footprint of a level-0 box.
inline constexpr int kPatchSize = 64;

struct PatchKey {
    std::int32_t px = 0, pz = 0;  ///< floor(x / 64), floor(z / 64)
    friend bool operator==(const PatchKey&, const PatchKey&) = default;
};
struct PatchKeyHash {
    std::size_t operator()(const PatchKey& k) const noexcept;
};

/// One return in voxel space: fixed point with 12 fractional bits relative to the data set's base, so that `>> 12` is exactly
/// the voxel that the point was in before rounding.
struct VoxelPoint {
    static constexpr int kFractionBits = 12;
    std::int32_t x = 0, y = 0, z = 0;
    std::uint8_t source_class = 0;
    std::uint8_t flags = 0;  ///< reserved
    std::array<std::uint16_t, 3> rgb{};
};
static_assert(sizeof(VoxelPoint) == 20);

/// The integer voxel that fixed-point coordinates count from: a multiple of 64 near the data's middle (y: 0).
struct Base {
    std::int32_t x = 0, z = 0;
};

/// A LiDAR square, decoded once: its points in voxel space, grouped by patch. Immutable.
class Square {
public:
    [[nodiscard]] std::span<const VoxelPoint> points(PatchKey patch) const noexcept;
    [[nodiscard]] std::span<const VoxelPoint> all() const noexcept { return m_points; }
    [[nodiscard]] std::size_t memory_bytes() const noexcept { return m_points.size() * sizeof(VoxelPoint) + m_ranges.size() * 48 + sizeof(Square); }
    [[nodiscard]] int colour_shift() const noexcept { return m_colour_shift; }  ///< bits to drop for 8-bit colour
    [[nodiscard]] bool has_colour() const noexcept { return m_has_colour; }
    [[nodiscard]] std::uint64_t wild_points() const noexcept { return m_wild_points; }  ///< left out: far outside the header's bounds

    /// Groups points (in file order) by patch, keeping their order within a patch.
    static std::shared_ptr<const Square> from_points(std::vector<std::vector<VoxelPoint>> parts, std::uint64_t wild_points);

private:
    struct Range { std::size_t begin, end; };
    std::vector<VoxelPoint> m_points;
    std::unordered_map<PatchKey, Range, PatchKeyHash> m_ranges;
    std::uint64_t m_wild_points = 0;
    int m_colour_shift = 0;
    bool m_has_colour = false;
};

/// How to read one file into voxel space.
struct SquareSource {
    lidar::LasInfo info;
    double vertical_metres = 1;  ///< metres per unit of the file's heights
    bool transform = false;      ///< the file's CRS differs from the frame's
};

/// Decodes a file with several readers at once: steps "point load" (LASzip) and "transformation" (CRS, voxel space).
/// Noise (role drop) and withheld points are left out. @throws Error for a damaged file
[[nodiscard]] std::shared_ptr<const Square> load_square(const SquareSource& source, const Frame& frame, Base base, const ClassTable& classes,
                                                        int threads);

}  // namespace terravox::voxelize
