#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>

#include "raytracer/core/output/exr_channels.hpp"

namespace terravox::output {

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
