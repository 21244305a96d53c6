#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "common/util/atomic_file.hpp"
#include "raytracer/core/output/picture.hpp"

namespace terravox::output {

/// How the values of a channel are stored. Bytes are sRGB, the others linear.
enum class SampleType { kByte, kHalf, kFloat };

struct FileChannel {
    std::string name;
    SampleType type = SampleType::kFloat;
};

/// How a picture is laid out in a file.
struct FileShape {
    int width_px = 0;
    int height_px = 0;
    std::vector<FileChannel> channels;
    /// OpenImageIO's name, with a level or a quality: "zip:2"; empty: the usual one of the format.
    std::string compression;
    /// 0: in rows, from the top. Otherwise the edge of tiles, which may be written in any order
    /// ("random" line order), so that none is kept in memory: .exr alone.
    int tile_px = 0;
};

/// Pixels of a rectangle in memory: row by row, the channels of a pixel one after the other, each
/// in its type, without gaps.
struct PixelBand {
    int x0 = 0;
    int y0 = 0;
    int x1 = 0;  ///< exclusive
    int y1 = 0;  ///< exclusive
    const std::byte* pixels = nullptr;
};

/// Writes the parts of a file; PictureFile says what they are.
class PictureEncoder {
public:
    virtual ~PictureEncoder() = default;
    virtual void write(const PixelBand& band) = 0;
    /// Every byte is in the file when it returns.
    virtual void finish() = 0;
};

/// A picture file that OpenImageIO writes, in the format of its ending. It appears under its name
/// when it is complete. The first one in a process loads terravox-pictures.so, and OpenImageIO with
/// it (docs/adr/0048). The same pixels and texts give the same bytes. Not thread-safe.
class PictureFile {
public:
    /// @param info texts and matrices; the format stores those that it has a place for
    /// @throws Error when the file cannot be written, or the module cannot be loaded
    PictureFile(const std::filesystem::path& file, const FileShape& shape, const PictureInfo& info);

    /// @param band in rows: the whole width, below what was written before; in tiles: whole tiles
    /// of the file, each once
    /// @throws Error with the reason, such as a full disk
    void write(const PixelBand& band) { m_encoder->write(band); }
    /// Completes the file.
    /// @param late_texts of an .exr: metadata that are known last; each replaces one of the same
    /// name and length
    /// @throws Error as write(); an older file of that name stays as it was
    void finish(const ImageMetadata& late_texts = {});

private:
    std::string m_attempt;
    util::AtomicFile m_target;  // outlives the encoder, which writes to it
    std::unique_ptr<PictureEncoder> m_encoder;
};

/// Whether this OpenImageIO writes a format.
/// @param ending ".exr"
/// @throws Error when the module cannot be loaded
[[nodiscard]] bool can_encode(const std::string& ending);

/// The interface of terravox-pictures.so: one function, exported under the name below. Exceptions
/// pass through unchanged: program and module are built together, by one compiler.
struct PictureModule {
    bool (*can_encode)(const std::string& ending);
    /// @param ending of the format; the name of `file` may have another
    /// @param attempt begins the messages, such as "write the picture a.exr"
    std::unique_ptr<PictureEncoder> (*encode)(const std::filesystem::path& file,
                                              const std::string& ending, const FileShape& shape,
                                              const PictureInfo& info, const std::string& attempt);
};
/// @param version of the caller: kVersion
/// @throws Error when the module is of another version
using FindPictureModule = const PictureModule&(const char* version);
inline constexpr const char* kFindPictureModule = "terravox_find_picture_module";

}  // namespace terravox::output
