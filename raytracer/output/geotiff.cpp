#include "raytracer/output/geotiff.hpp"

#include <cstdio>

#include "common/util/atomic_file.hpp"
#include "raytracer/output/gdal_writing.hpp"
#include "raytracer/output/pixel_bytes.hpp"

namespace terravox::output {
namespace {

constexpr int kBands = 4;

/// Makes the picture in memory accessible to GDAL without a copy.
void add_bands(GDALDatasetH memory, const void* first, GDALDataType type, std::size_t sample_bytes,
               std::size_t pixel_bytes, std::size_t row_bytes, const GdalWatch& watch) {
    constexpr std::array<GDALColorInterp, kBands> kMeaning = {GCI_RedBand, GCI_GreenBand,
                                                              GCI_BlueBand, GCI_AlphaBand};
    for (std::size_t band = 0; band < kBands; ++band) {
        char pointer[32];
        std::snprintf(
            pointer, sizeof pointer, "%p",
            static_cast<const void*>(static_cast<const std::byte*>(first) + band * sample_bytes));
        GdalOptions options = {{"DATAPOINTER", pointer},
                               {"PIXELOFFSET", std::to_string(pixel_bytes)},
                               {"LINEOFFSET", std::to_string(row_bytes)}};
        watch.check(GDALAddBand(memory, type, options.list()) == CE_None);
        GDALSetRasterColorInterpretation(GDALGetRasterBand(memory, static_cast<int>(band) + 1),
                                         kMeaning[band]);
    }
}

}  // namespace

void write_geotiff(const Film& film, const std::filesystem::path& file, const PictureInfo& info) {
    const GdalWatch watch("write the picture " + file.string());
    const int width = film.width_px();
    const int height = film.height_px();
    const auto columns = static_cast<std::size_t>(width);
    const bool floats = info.tiff_holds_floats();
    std::vector<std::uint8_t> bytes;  // must outlive the dataset that refers to it
    const GdalDataset memory(
        GDALCreate(GDALGetDriverByName("MEM"), "", width, height, 0, GDT_Byte, nullptr));
    watch.check(memory != nullptr);
    if (floats) {
        // Red, green, blue and alpha are the first four floats of each sample.
        static_assert(offsetof(tiles::PixelSample, alpha) == 3 * sizeof(float));
        add_bands(memory.get(), film.samples().data(), GDT_Float32, sizeof(float),
                  sizeof(tiles::PixelSample), columns * sizeof(tiles::PixelSample), watch);
    } else {
        const PixelBytes make(info, width, height);
        bytes.resize(columns * static_cast<std::size_t>(height) * kBands);
        std::uint8_t* to = bytes.data();
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x, to += kBands)
                make.put_with_alpha(film.at(x, y), x, y, to);
        add_bands(memory.get(), bytes.data(), GDT_Byte, 1, kBands, columns * kBands, watch);
    }
    describe_geotiff(memory.get(), info, watch);
    util::AtomicFile target(file);
    CogOptions options;
    options.has_floats = floats;
    write_cog(memory.get(), target.temporary_path(), options, watch);
    target.commit();
}

}  // namespace terravox::output
