#pragma once

#include <OpenImageIO/imageio.h>

#include <cstddef>
#include <vector>

#include "raytracer/output/cryptomatte.hpp"
#include "raytracer/output/picture_info.hpp"
#include "raytracer/tiles/tile.hpp"

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

    /// Sets channels, their types, and all metadata that need no more than `info`.
    void describe(OIIO::ImageSpec& spec) const;
    [[nodiscard]] std::size_t pixel_bytes() const noexcept { return m_pixel_bytes; }
    /// Writes the channels of one pixel, each in its type, one after the other.
    /// @param layers nullptr: not known for this pixel; all become 0
    void put(const tiles::PixelSample& sample, const tiles::LayerSample* layers,
             std::byte* out) const noexcept;

private:
    const PictureInfo& m_info;
    bool m_with_layers;
    Cryptomatte m_materials;
    Cryptomatte m_squares;
    std::vector<std::string> m_names;
    std::vector<OIIO::TypeDesc> m_types;
    std::size_t m_pixel_bytes = 0;
};

/// Stores the contents of `info` other than light: names and values and, for formats that support
/// them, the matrices of the camera.
void describe_picture(const PictureInfo& info, OIIO::ImageSpec& spec);

}  // namespace terravox::output
