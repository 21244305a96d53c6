#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "voxelserver/data/grid/frame.hpp"
#include "voxelserver/data/grid/patch.hpp"
#include "voxelserver/data/imagery/image.hpp"

namespace terravox::imagery {

/// A rectangle of columns, in absolute voxels.
struct ColumnRect {
    std::int32_t x = 0;
    std::int32_t z = 0;
    int width = 0;
    int height = 0;
};

/// A position in the pixels of an image, e.g. that of a column's centre, or a step from column to
/// column. Fixed point, kOne per pixel, so that further arithmetic is exact.
struct PixelPlace {
    static constexpr std::int64_t kOne = 65536;
    std::int64_t u = 0;
    std::int64_t v = 0;
};

/// Maps columns to pixels of one image. The exact transform (affine, or through PROJ for another
/// CRS) is evaluated at the nodes of an absolute lattice, kCell voxels apart, and interpolated
/// bilinearly between: a column's position does not depend on the requested rectangle. Between two
/// map projections the error is about (cell length)^2 / (8 Earth radii): 0.1 mm for cells of 64 m.
class PixelMap {
public:
    static constexpr int kCell = 64;

    /// Requires the caller to hold gdal_mutex().
    /// @throws Error when PROJ has no operation from the frame's CRS to the image's
    PixelMap(const grid::Frame& frame, const Image& image);

    /// The bounding box of the image's outline, west to east and north to south: continuous voxels.
    /// Not finite where PROJ has no operation.
    struct Extent {
        double x0 = 0;
        double z0 = 0;
        double x1 = 0;
        double z1 = 0;
    };
    [[nodiscard]] const Extent& extent() const noexcept { return m_extent; }
    /// The columns outside of which the image has no influence.
    [[nodiscard]] grid::ColumnRect influence() const noexcept;
    /// The columns of `rect` that the image may cover, with a safety margin; empty (width 0) when
    /// there are none.
    [[nodiscard]] ColumnRect covered(const ColumnRect& rect) const noexcept;
    /// Side of a voxel in pixels.
    [[nodiscard]] double pixels_per_voxel() const noexcept { return m_pixels_per_voxel; }

    /// One lattice cell: pixel coordinates of the corners in the order (0,0), (1,0), (0,1), (1,1).
    struct Cell {
        std::array<double, 4> u{};
        std::array<double, 4> v{};
        /// Position of the column (x, z) in [0, kCell).
        [[nodiscard]] PixelPlace centre(int x, int z) const noexcept;
        [[nodiscard]] PixelPlace step_x() const noexcept;  ///< pixels from one column to the next
        [[nodiscard]] PixelPlace step_z() const noexcept;
    };
    /// The cells [x0, x0 + nx) x [z0, z0 + nz) of the lattice, row by row. Requires the caller to
    /// hold gdal_mutex().
    /// @throws Error outside PROJ's domain
    [[nodiscard]] std::vector<Cell> cells(std::int32_t x0, std::int32_t z0, int nx, int nz) const;

private:
    void to_pixels(std::vector<double>& e, std::vector<double>& n) const;
    const grid::Frame* m_frame;
    std::array<double, 6> m_inverse{};  ///< from coordinates of the image's CRS to pixels
    std::unique_ptr<geo::Transform> m_to_image;
    std::optional<double> m_middle_deg;  ///< longitude of an image in degrees
    Extent m_extent;
    double m_room = 0;  ///< safety margin around it, in voxels
    double m_pixels_per_voxel = 1;
};

/// The positions of a rectangle of columns in one image.
struct ColumnPlaces {
    ColumnRect rect;
    std::vector<PixelPlace> centres;  ///< index = z * width + x
    /// For each lattice cell, `samples` x `samples` positions relative to a column's centre.
    std::vector<PixelPlace> offsets;
    std::vector<std::uint32_t> cell;  ///< for each column: the index of its offsets
    /// Samples along each side of a column; 1 = the image is coarser: bilinear interpolation at the
    /// centre.
    int samples = 1;
};

/// Number of samples along a column's side: 1 where pixels are as wide as a voxel or wider, else 4
/// to 16, which covers each pixel of an image that is up to 16 times finer at least once.
[[nodiscard]] int samples_for(double pixels_per_voxel) noexcept;

/// Requires the caller to hold gdal_mutex().
/// @throws Error outside the domain of the image's projection
[[nodiscard]] ColumnPlaces find_places(const PixelMap& map, const ColumnRect& rect);

/// The window of pixels that mean_at() may access; width 0 when none of the columns lies in the
/// image.
[[nodiscard]] PixelWindow find_window(const ColumnPlaces& places, int image_width,
                                      int image_height) noexcept;

/// The image's value for column `index`: the mean over the column's footprint (finer images) or the
/// bilinear value at its centre (coarser ones). Pixels without data are excluded; a column has a
/// value where the pixel under its centre has data. Uses integer arithmetic on absolute positions:
/// a column's value is independent of the window that was read.
/// @return false when the column has no value
[[nodiscard]] bool mean_at(const ColumnPlaces& places, std::size_t index, const Pixels& pixels,
                           Pixel& out) noexcept;

}  // namespace terravox::imagery
