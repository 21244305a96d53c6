#include <array>
#include <memory>

#include "common/util/atomic_file.hpp"
#include "common/util/error.hpp"
#include "raytracer/core/output/gdal_writing.hpp"
#include "raytracer/core/output/pixel_bytes.hpp"
#include "raytracer/core/output/stream_formats.hpp"

namespace terravox::output {
namespace {

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
        if (edge == 0)
            throw util::Error(m_attempt + ": tiles of " + std::to_string(shape.tile_px) +
                              " pixels, which check_can_stream refuses");
        const GdalWatch watch(m_attempt);
        GdalOptions options = {{"TILED", "YES"},
                               {"BLOCKXSIZE", std::to_string(edge)},
                               {"BLOCKYSIZE", std::to_string(edge)},
                               {"COMPRESS", "DEFLATE"},
                               {"PREDICTOR", m_floats ? "3" : "2"},
                               {"INTERLEAVE", "PIXEL"},
                               {"BIGTIFF", "YES"},
                               {"PHOTOMETRIC", "RGB"},
                               {"ALPHA", "UNSPECIFIED"}};
        m_out.reset(GDALCreate(GDALGetDriverByName("GTiff"),
                               m_target.temporary_path().string().c_str(), shape.width_px,
                               shape.height_px, kBands, m_floats ? GDT_Float32 : GDT_Byte,
                               options.list()));
        watch.check(m_out != nullptr);
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

std::unique_ptr<TileStream::Format> make_tiff_stream(const std::filesystem::path& file,
                                                     const StreamShape& shape, PictureInfo info) {
    return std::make_unique<TiffStream>(file, shape, std::move(info));
}

}  // namespace terravox::output
