#pragma once

#include <cstdint>
#include <vector>

#include "common/voxel/material.hpp"

namespace terravox::imagery {

/// The images' values for a rectangle of columns, index = z * width + x. The vectors are empty
/// where there is no image at all.
struct Raster {
    static constexpr std::uint8_t kColour = 1;  ///< flag: `colour` is known
    static constexpr std::uint8_t kNir = 2;     ///< flag: `nir` and `red` are known

    int width = 0;
    int height = 0;
    std::vector<voxel::Rgb8> colour;
    std::vector<std::uint8_t> nir;  ///< near infrared
    /// Red value of the same image that `nir` comes from, since only the two together give a
    /// vegetation index.
    std::vector<std::uint8_t> red;
    std::vector<std::uint8_t> flags;
    /// Where `colour` is known: the image that it comes from, an index into Orthophotos::inputs().
    std::vector<std::uint32_t> image;

    [[nodiscard]] bool empty() const noexcept { return flags.empty(); }
};

}  // namespace terravox::imagery
