#include "raytracer/core/output/tile_stream.hpp"

#include <algorithm>
#include <cstddef>
#include <string>

#include "common/util/atomic_file.hpp"
#include "common/util/error.hpp"
#include "common/util/text.hpp"
#include "raytracer/core/output/develop.hpp"
#include "raytracer/core/output/exr_channels.hpp"
#include "raytracer/core/output/gdal_writing.hpp"
#include "raytracer/core/output/picture_file.hpp"

namespace terravox::output {
namespace {

int tiles_along(int size_px, int tile_px) noexcept {
    return (size_px + tile_px - 1) / tile_px;
}

}  // namespace

bool must_stream(const StreamShape& s, std::uint64_t limit_bytes) noexcept {
    return Film::bytes(s.width_px, s.height_px, s.with_layers) > limit_bytes;
}

std::uint64_t memory_to_keep_mib(const StreamShape& s) noexcept {
    constexpr std::uint64_t kHalfMib = std::uint64_t{1} << 19;
    return (Film::bytes(s.width_px, s.height_px, s.with_layers) + kHalfMib - 1) / kHalfMib;
}

void check_can_stream(const std::filesystem::path& file, const StreamShape& s) {
    constexpr int kTiffTiles = 16;
    const std::string ending = util::lower_extension(file);
    const std::string attempt = "write the picture " + file.string() + ": ";
    const std::string memory = std::to_string(memory_to_keep_mib(s));
    if (ending == ".exr")
        return;
    if (ending != ".tif" && ending != ".tiff")
        throw util::UsageError(
            attempt + std::to_string(s.width_px) + "x" + std::to_string(s.height_px) +
            " pixels need " +
            std::to_string(Film::bytes(s.width_px, s.height_px, s.with_layers) >> 20) +
            " MiB, more than there is for a picture, and '" + ending +
            "' cannot be written in parts; allowed at this size: .exr .tif, or --memory-mib " +
            memory + " and more");
    if (file_tile_px(s.tile_px, kTiffTiles) == 0)
        throw util::UsageError(
            attempt + "tiles of " + std::to_string(s.tile_px) +
            " pixels; allowed for .tif at this size: multiples of 16, or --memory-mib " + memory +
            " and more");
}

int file_tile_px(int tile_px, int multiple_of) noexcept {
    constexpr int kMax = 512;
    constexpr int kMin = 16;
    for (int edge = std::min(tile_px, kMax); edge >= kMin; --edge)
        if (tile_px % edge == 0 && edge % multiple_of == 0)
            return edge;
    return multiple_of == 1 ? tile_px : 0;
}

namespace {

constexpr const char* kHoles = "terravox:holes";
constexpr std::size_t kHolesDigits = 12;

/// With leading zeros: a text whose length does not depend on the number.
std::string to_digits(std::uint64_t n) {
    const std::string text = std::to_string(n);
    return std::string(kHolesDigits - std::min(kHolesDigits, text.size()), '0') + text;
}

PictureInfo with_room_for_holes(PictureInfo info) {
    std::erase_if(info.metadata, [](const auto& item) { return item.first == kHoles; });
    info.metadata.emplace_back(kHoles, to_digits(0));
    return info;
}

/// Through OpenImageIO; tiles in any order, as its random line order allows, so that none is
/// buffered in memory.
class ExrStream final : public TileStream::Format {
public:
    ExrStream(const std::filesystem::path& file, const StreamShape& shape, PictureInfo info)
        : m_channels(shape.with_layers, with_room_for_holes(std::move(info))),
          m_edge(file_tile_px(shape.tile_px, 1)),
          m_file(file, {shape.width_px, shape.height_px, m_channels.list(), "zip:2", m_edge},
                 m_channels.info()) {}

    void write(const tiles::TileResult& result) override {
        const tiles::RenderTile& t = result.tile;
        const auto width = static_cast<std::size_t>(t.x1 - t.x0);
        // A row of the file's tiles at a time: as much as OpenEXR can compress in parallel without
        // twice the memory of the result.
        for (int y0 = t.y0; y0 < t.y1; y0 += m_edge) {
            const int y1 = std::min(y0 + m_edge, t.y1);
            m_band.resize(width * static_cast<std::size_t>(y1 - y0) * m_channels.pixel_bytes());
            std::byte* to = m_band.data();
            const std::size_t begin = static_cast<std::size_t>(y0 - t.y0) * width;
            const std::size_t end = static_cast<std::size_t>(y1 - t.y0) * width;
            for (std::size_t i = begin; i < end; ++i) {
                m_channels.put(result.samples[i],
                               result.layers.empty() ? nullptr : &result.layers[i], to);
                to += m_channels.pixel_bytes();
            }
            m_file.write({t.x0, y0, t.x1, y1, m_band.data()});
        }
    }

    void finish(std::uint64_t holes) override { m_file.finish({{kHoles, to_digits(holes)}}); }

private:
    ExrChannels m_channels;
    int m_edge;
    PictureFile m_file;
    std::vector<std::byte> m_band;
};

/// Through GDAL; only its block cache (common/geo/gdal.hpp) buffers tiles in memory.
class TiffStream final : public TileStream::Format {
public:
    TiffStream(const std::filesystem::path& file, const StreamShape& shape, PictureInfo info)
        : m_attempt("write the picture " + file.string()),
          m_info(std::move(info)),
          m_bytes(m_info, shape.width_px, shape.height_px),
          m_floats(m_info.tiff_holds_floats()),
          m_target(file) {
        constexpr int kTiffTiles = 16;
        const int edge = file_tile_px(shape.tile_px, kTiffTiles);
        const GdalWatch watch(m_attempt);
        m_out = create_tiff(m_target.temporary_path(),
                            {shape.width_px, shape.height_px, kBands,
                             m_floats ? GDT_Float32 : GDT_Byte, edge, edge},
                            {{"PREDICTOR", m_floats ? "3" : "2"},
                             {"INTERLEAVE", "PIXEL"},
                             {"PHOTOMETRIC", "RGB"},
                             {"ALPHA", "UNSPECIFIED"}},
                            watch);
        GDALSetRasterColorInterpretation(GDALGetRasterBand(m_out.get(), kBands), GCI_AlphaBand);
        describe_geotiff(m_out.get(), m_info, watch);
    }

    void write(const tiles::TileResult& result) override {
        const GdalWatch watch(m_attempt);
        const tiles::RenderTile& t = result.tile;
        const int width = t.x1 - t.x0;
        const int height = t.y1 - t.y0;
        const tiles::PixelSample* from = result.samples.data();
        if (m_floats) {
            // Red, green, blue and alpha are the first four floats of each sample.
            static_assert(offsetof(tiles::PixelSample, alpha) == 3 * sizeof(float));
            put(t, const_cast<tiles::PixelSample*>(from), GDT_Float32, sizeof(tiles::PixelSample),
                sizeof(float), watch);
            return;
        }
        m_pixels.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) *
                        kBands);
        std::uint8_t* to = m_pixels.data();
        for (int y = t.y0; y < t.y1; ++y)
            for (int x = t.x0; x < t.x1; ++x, to += kBands)
                m_bytes.put_with_alpha(*from++, x, y, to);
        put(t, m_pixels.data(), GDT_Byte, kBands, 1, watch);
    }

    void finish(std::uint64_t holes) override {
        const GdalWatch watch(m_attempt);
        GDALSetMetadataItem(m_out.get(), gdal_name("terravox:holes").c_str(),
                            std::to_string(holes).c_str(), nullptr);
        GDALFlushCache(m_out.get());
        m_out.reset();
        watch.check_closed_tiff(m_target.temporary_path());
        m_target.commit();
    }

private:
    void put(const tiles::RenderTile& t, void* first, GDALDataType type, std::size_t pixel_bytes,
             std::size_t band_bytes, const GdalWatch& watch) {
        const int width = t.x1 - t.x0;
        const int height = t.y1 - t.y0;
        watch.check(GDALDatasetRasterIOEx(m_out.get(), GF_Write, t.x0, t.y0, width, height, first,
                                          width, height, type, kBands, nullptr,
                                          static_cast<GSpacing>(pixel_bytes),
                                          static_cast<GSpacing>(pixel_bytes) * width,
                                          static_cast<GSpacing>(band_bytes), nullptr) == CE_None);
    }
    static constexpr int kBands = 4;
    std::string m_attempt;
    PictureInfo m_info;
    PixelBytes m_bytes;
    bool m_floats;
    util::AtomicFile m_target;  // outlives the dataset that writes to it
    GdalDataset m_out;
    std::vector<std::uint8_t> m_pixels;
};

}  // namespace

TileStream::TileStream(const std::filesystem::path& file, const StreamShape& shape,
                       PictureInfo info)
    : m_shape(shape) {
    check_can_stream(file, shape);
    const auto columns = static_cast<std::uint64_t>(tiles_along(shape.width_px, shape.tile_px));
    const auto rows = static_cast<std::uint64_t>(tiles_along(shape.height_px, shape.tile_px));
    m_left = columns * rows;
    m_done.resize(m_left);
    info = with_clean_texts(std::move(info));
    if (util::lower_extension(file) == ".exr")
        m_format = std::make_unique<ExrStream>(file, shape, std::move(info));
    else
        m_format = std::make_unique<TiffStream>(file, shape, std::move(info));
}

TileStream::~TileStream() = default;

void TileStream::check_tile(const tiles::RenderTile& t) {
    const int edge = m_shape.tile_px;
    const bool fits = t.step == 1 && !t.refines && t.x0 >= 0 && t.y0 >= 0 && t.x0 % edge == 0 &&
                      t.y0 % edge == 0 && t.x0 < m_shape.width_px && t.y0 < m_shape.height_px &&
                      t.x1 == std::min(t.x0 + edge, m_shape.width_px) &&
                      t.y1 == std::min(t.y0 + edge, m_shape.height_px);
    const auto place = [&] {
        return "(" + std::to_string(t.x0) + ", " + std::to_string(t.y0) + ")";
    };
    if (!fits)
        throw util::Error("stream the picture: the tile at " + place() +
                          " is none of a single pass in tiles of " + std::to_string(edge) +
                          " pixels");
    const auto index = static_cast<std::size_t>(t.y0 / edge) *
                           static_cast<std::size_t>(tiles_along(m_shape.width_px, edge)) +
                       static_cast<std::size_t>(t.x0 / edge);
    if (m_done[index])
        throw util::Error("stream the picture: the tile at " + place() + " came twice");
    m_done[index] = true;
    --m_left;
}

void TileStream::add(const tiles::TileResult& result) {
    if (!m_format)
        throw util::Error("stream the picture: a tile came after the end");
    check_tile(result.tile);
    const auto pixels = static_cast<std::size_t>(result.tile.x1 - result.tile.x0) *
                        static_cast<std::size_t>(result.tile.y1 - result.tile.y0);
    if (result.samples.size() != pixels || (m_shape.with_layers && result.layers.size() != pixels))
        throw util::Error("stream the picture: a tile of " + std::to_string(pixels) +
                          " pixels has " + std::to_string(result.samples.size()) + " samples and " +
                          std::to_string(result.layers.size()) + " of its layers");
    m_format->write(result);
}

void TileStream::finish(std::uint64_t holes) {
    if (!m_format)
        throw util::Error("stream the picture: ended twice");
    if (m_left > 0)
        throw util::Error("stream the picture: " + std::to_string(m_left) + " tiles are missing");
    m_format->finish(holes);
    m_format.reset();
}

}  // namespace terravox::output
