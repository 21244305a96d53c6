#pragma once

#include <vector>

#include "voxelserver/imagery/image.hpp"
#include "voxelserver/imagery/pixel_map.hpp"

namespace terravox::imagery {

/// The places of a rectangle of columns in one image.
struct ColumnPlaces {
    ColumnRect rect;
    std::vector<PixelPlace> centres;  ///< index = z * width + x
    std::vector<PixelPlace>
        offsets;  ///< of each lattice cell, `samples` x `samples` places relative to a centre
    std::vector<std::uint32_t> cell;  ///< of each column: which offsets
    int samples =
        1;  ///< along each side of a column; 1 = the image is coarser: bilinear at the centre
};

/// How many places along a column's side are looked at: each pixel of a finer image at least once,
/// and at least 4.
[[nodiscard]] int samples_for(double pixels_per_voxel) noexcept;

/// The caller holds gdal_mutex(). @throws Error outside the domain of the image's projection
[[nodiscard]] ColumnPlaces places_of(const PixelMap& map, const ColumnRect& rect);

/// The pixels that mean_at() may ask for; width 0 when none of the columns lies in the image.
[[nodiscard]] PixelWindow window_of(const ColumnPlaces& places, int image_width,
                                    int image_height) noexcept;

/// What the image shows in column `index`: the mean over the column's footprint (finer images) or
/// the bilinear value at its centre (coarser ones). Pixels without data take no part; a column has
/// a value where the pixel under its centre has data. Integer arithmetic on absolute places: a
/// column's value is the same whatever window it is read with.
/// @return false without a value
[[nodiscard]] bool mean_at(const ColumnPlaces& places, std::size_t index, const Pixels& pixels,
                           Pixel& out) noexcept;

}  // namespace terravox::imagery
