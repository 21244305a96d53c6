#pragma once

#include <vector>

#include "voxelserver/data/imagery/image.hpp"
#include "voxelserver/data/imagery/pixel_map.hpp"

namespace terravox::imagery {

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

/// Number of samples along a column's side: covers each pixel of a finer image at least once, and
/// is at least 4.
[[nodiscard]] int samples_for(double pixels_per_voxel) noexcept;

/// Requires the caller to hold gdal_mutex().
/// @throws Error outside the domain of the image's projection
[[nodiscard]] ColumnPlaces places_of(const PixelMap& map, const ColumnRect& rect);

/// The window of pixels that mean_at() may access; width 0 when none of the columns lies in the
/// image.
[[nodiscard]] PixelWindow window_of(const ColumnPlaces& places, int image_width,
                                    int image_height) noexcept;

/// The image's value for column `index`: the mean over the column's footprint (finer images) or the
/// bilinear value at its centre (coarser ones). Pixels without data are excluded; a column has a
/// value where the pixel under its centre has data. Uses integer arithmetic on absolute positions:
/// a column's value is independent of the window that was read.
/// @return false when the column has no value
[[nodiscard]] bool mean_at(const ColumnPlaces& places, std::size_t index, const Pixels& pixels,
                           Pixel& out) noexcept;

}  // namespace terravox::imagery
