#pragma once

#include <cstddef>
#include <vector>

#include "raytracer/core/output/cryptomatte.hpp"
#include "raytracer/core/output/picture.hpp"
#include "raytracer/core/output/picture_file.hpp"
#include "raytracer/core/tiles/tile.hpp"

namespace terravox::output {

/// The channels of an EXR picture, in one part.
///   R, G, B, A           float  the picture, linear Rec. 709, and the share of samples that hit
///                               the world
///   Z                    float  mean distance of those, metres; infinity where there are none
/// and with layers, as described at LayerSample:
///   albedo.R/G/B         half   share of light that the surface reflects
///   direct.R/G/B         half   light that reaches the first hit directly from sun and sky; with
///                               indirect it makes R, G, B
///   indirect.R/G/B       half
///   normal.X/Y/Z         half   x east, y up, z south
///   position.X/Y/Z       float  metres from the origin that the metadata name, the same axes
///   material.ID          half   number of voxel::Material, a whole number below 2048, which half
///                               represents exactly
///   sun.V, water.V       half   shares
///   CryptoMaterial00..02.r/g/b/a, CryptoSquare00..02.r/g/b/a   float
/// Half is exact to 1 in 2048, ends at 65504 (more light is clamped to that), and takes half the
/// space. Safe to share between threads.
class ExrChannels {
public:
    ExrChannels(bool with_layers, const PictureInfo& info);

    [[nodiscard]] const std::vector<FileChannel>& list() const noexcept { return m_list; }
    /// Those given, and of a picture with layers the texts of its mattes.
    [[nodiscard]] const PictureInfo& info() const noexcept { return m_info; }
    [[nodiscard]] std::size_t pixel_bytes() const noexcept { return m_pixel_bytes; }
    /// Writes the channels of one pixel, each in its type, one after the other.
    /// @param layers nullptr: not known for this pixel; all become 0
    void put(const tiles::PixelSample& sample, const tiles::LayerSample* layers,
             std::byte* out) const noexcept;

private:
    PictureInfo m_info;
    bool m_with_layers;
    Cryptomatte m_materials;
    Cryptomatte m_squares;
    std::vector<FileChannel> m_list;
    std::size_t m_pixel_bytes = 0;
};

}  // namespace terravox::output
