#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "voxelserver/data/grid/patch.hpp"
#include "voxelserver/data/imagery/orthophotos.hpp"

namespace terravox::voxelize {

/// Weights by which values that were found for each image are interpolated over a mosaic of them:
/// bilinear between the middles of equal images that lie side by side.
///
/// Images of several years, or frames of a drone, cover the same columns again and again. Of these,
/// only those count for each other that can be of one mosaic: they are of one series, and overlap
/// by less than half. So no more than kMostImages count at a column.
class PhotoMosaic {
public:
    static constexpr std::size_t kMostImages = 4;

    /// @param images in order of precedence
    explicit PhotoMosaic(std::span<const imagery::Orthophotos::Input> images);

    /// The images that count somewhere in an image, rising; the image itself is one of them.
    [[nodiscard]] const std::vector<std::size_t>& around(std::size_t image) const noexcept {
        return m_around[image];
    }

    struct Weight {
        std::size_t image = 0;
        float weight = 0;  ///< positive
    };
    /// How much images count at a column of one of them, by rising index: each 1 in its middle,
    /// less to all sides, and nothing from half its size outside of it on. Over equal images side
    /// by side the sum is 1. Where more images than four would count, all weights are lowered by
    /// that of the fifth, so that they change continuously. Flights are not told apart here: that
    /// needs the light of each.
    /// @return at most kMostImages; none where no image counts
    [[nodiscard]] std::vector<Weight> weights(std::size_t image, std::int32_t x,
                                              std::int32_t z) const;

private:
    /// The other images of the same series that count somewhere in an image, or overlap it.
    [[nodiscard]] std::vector<std::size_t> near(std::size_t image) const;
    void find_mosaics();

    struct Place {
        grid::ColumnRect rect;
        std::size_t series = 0;
        std::size_t mosaic = 0;  ///< of the series
    };
    std::vector<Place> m_images;
    std::vector<std::vector<std::size_t>> m_around;
    std::vector<std::size_t> m_west_to_east;  ///< by their western edges
    std::int64_t m_max_width = 0;
};

}  // namespace terravox::voxelize
