#pragma once

#include <ImathBox.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfPixelType.h>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "raytracer/core/output/cryptomatte.hpp"
#include "raytracer/core/output/picture.hpp"
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

    /// Sets channels, their types, and all metadata.
    void describe(Imf::Header& header) const;
    /// Where OpenEXR finds the values of pixels that put() wrote, row by row.
    /// @param area their place in the picture; its bounds are inclusive
    [[nodiscard]] Imf::FrameBuffer frame(const std::byte* pixels, const Imath::Box2i& area) const;
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
    struct Channel {
        std::string name;
        Imf::PixelType type;
        std::size_t offset;  ///< in the bytes of a pixel
    };
    std::vector<Channel> m_channels;
    std::size_t m_pixel_bytes = 0;
};

/// Pixels of a rectangle in memory: row by row, the channels of a pixel one after the other, as
/// ExrChannels::put() writes them.
struct ExrBand {
    int x0 = 0;
    int y0 = 0;
    int x1 = 0;  ///< exclusive
    int y1 = 0;  ///< exclusive
    const std::byte* pixels = nullptr;
};

/// How the pixels of a file are arranged.
struct ExrShape {
    int width_px = 0;
    int height_px = 0;
    /// 0: in rows, from the top. Otherwise the edge of tiles, which may be written in any order
    /// ("random" line order), so that none is kept in memory.
    int tile_px = 0;
};

/// An OpenEXR file of one part that is being written: ZIP compression, by one thread for each core.
/// It appears under its name when it is complete. Every byte goes to the disk through a stream of
/// ours: OpenEXR closes the files that it opens itself without checking the result, so on a full
/// disk the last bytes of a picture could be missing without an error. Not thread-safe.
class ExrFile {
public:
    /// @param channels must outlive this object
    /// @throws Error when the file cannot be written
    ExrFile(const std::filesystem::path& file, const ExrShape& shape, const ExrChannels& channels);
    ~ExrFile();
    ExrFile(const ExrFile&) = delete;
    ExrFile& operator=(const ExrFile&) = delete;

    /// @param band in rows: the whole width, below what was written before; in tiles: whole tiles
    /// of the file, each once
    /// @throws Error with the reason, such as a full disk
    void write(const ExrBand& band);
    /// Completes the file.
    /// @param late_texts metadata that are known last; each replaces one of the same name and
    /// length
    /// @throws Error as write(); an older file of that name stays as it was
    void finish(const ImageMetadata& late_texts = {});

private:
    class Parts;
    std::unique_ptr<Parts> m_parts;
};

}  // namespace terravox::output
