#include "raytracer/core/output/tiff_picture.hpp"

#include "common/util/atomic_file.hpp"
#include "raytracer/core/output/gdal_writing.hpp"
#include "raytracer/core/output/pixel_bytes.hpp"

namespace terravox::output {
namespace {

constexpr int kWithAlpha = 4;

/// Where the samples of a film lie. Red, green, blue and alpha are the first four floats of each.
PixelsInMemory floats_of(const Film& film) {
    static_assert(offsetof(tiles::PixelSample, alpha) == 3 * sizeof(float));
    return {film.samples().data(),     GDT_Float32, film.width_px(),
            film.height_px(),          kWithAlpha,  sizeof(float),
            sizeof(tiles::PixelSample)};
}

void write_in_strips(GDALDatasetH from, const std::filesystem::path& file, bool has_floats,
                     const GdalWatch& watch) {
    GdalOptions options = {{"COMPRESS", "DEFLATE"}, {"PREDICTOR", has_floats ? "3" : "2"},
                           {"BIGTIFF", "IF_SAFER"}, {"INTERLEAVE", "PIXEL"},
                           {"BLOCKYSIZE", "32"},    {"NUM_THREADS", "ALL_CPUS"}};
    if (has_floats)
        options.add("ALPHA", "PREMULTIPLIED");  // as in EXR
    GdalDataset out(GDALCreateCopy(GDALGetDriverByName("GTiff"), file.string().c_str(), from, FALSE,
                                   options.list(), nullptr, nullptr));
    watch.check(out != nullptr);
    out.reset();  // writes what is left
    watch.check_closed_tiff(file);
}

}  // namespace

void write_tiff(const Film& film, const std::filesystem::path& file, const PictureInfo& info) {
    const GdalWatch watch("write the picture " + file.string());
    const bool has_floats = info.tiff_holds_floats();
    std::vector<std::uint8_t> bytes;  // must outlive the dataset that refers to it
    PixelsInMemory pixels;
    if (has_floats) {
        pixels = floats_of(film);
    } else {
        const int channels = info.geo ? kWithAlpha : kWithAlpha - 1;
        bytes = developed_bytes(film, info, channels);
        pixels = byte_pixels(bytes, film.width_px(), film.height_px(), channels);
    }
    const GdalDataset memory = memory_dataset(pixels, watch);
    describe_geotiff(memory.get(), info, watch);
    util::AtomicFile target(file);
    if (info.geo) {
        CogOptions options;
        options.has_floats = has_floats;
        write_cog(memory.get(), target.temporary_path(), options, watch);
    } else {
        write_in_strips(memory.get(), target.temporary_path(), has_floats, watch);
    }
    target.commit();
}

}  // namespace terravox::output
