#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "voxelserver/grid/patch.hpp"

namespace terravox::voxelize {

/// Weights by which values that were found for each image are interpolated over a mosaic of them:
/// bilinear between the middles of equal images.
class PhotoMosaic {
public:
    /// @param images the columns outside of which an image has no influence
    explicit PhotoMosaic(std::vector<grid::ColumnRect> images);

    /// The images that count somewhere in an image, rising; the image itself is one of them.
    [[nodiscard]] std::vector<std::size_t> around(std::size_t image) const;
    /// How much an image counts at a column: 1 in its middle, less to all sides, and nothing from
    /// half its size outside of it on; over equal images side by side the sum is 1.
    [[nodiscard]] float weight(std::size_t image, std::int32_t x, std::int32_t z) const noexcept;

private:
    std::vector<grid::ColumnRect> m_images;
    std::vector<std::size_t> m_west_to_east;  ///< by their western edges
    std::int64_t m_max_width = 0;
};

}  // namespace terravox::voxelize
