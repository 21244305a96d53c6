#include "raytracer/core/output/image_writer.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "common/png/png.hpp"
#include "common/util/atomic_file.hpp"
#include "common/util/error.hpp"
#include "common/util/log.hpp"
#include "common/util/text.hpp"
#include "raytracer/core/output/develop.hpp"
#include "raytracer/core/output/exr_file.hpp"
#include "raytracer/core/output/gdal_writing.hpp"

namespace terravox::output {
namespace {

constexpr int kChannels = 3;

/// All of Exif has room for 64 KiB, and GDAL writes none of it when that does not suffice.
std::string cut_for_exif(const std::string& name, const std::string& text,
                         const std::string& attempt) {
    constexpr std::size_t kMaxBytes = 16384;
    if (text.size() <= kMaxBytes)
        return text;
    util::log_warn("{}: of {} only the first {} bytes are stored", attempt, name, kMaxBytes);
    std::size_t end = kMaxBytes;
    // Not in the middle of a character of UTF-8.
    while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0U) == 0x80U)
        --end;
    return text.substr(0, end);
}

void describe(GDALDatasetH dataset, const PictureInfo& info, const std::string& attempt) {
    const auto set = [&](const char* tag, const std::string& value) {
        GDALSetMetadataItem(dataset, tag, value.c_str(), nullptr);
    };
    constexpr const char* kSrgb = "1";
    set("EXIF_ColorSpace", kSrgb);
    for (const auto& [name, value] : info.metadata)
        if (name == "Software" || name == "Copyright" || name == "ImageDescription")
            set(("EXIF_" + name).c_str(), cut_for_exif(name, value, attempt));
}

}  // namespace

// libjpeg's writer does not report a full disk, so the file is made in memory and written here.
void write_jpeg(const Film& film, const std::filesystem::path& file, const PictureInfo& info) {
    const GdalWatch watch("write the picture " + file.string());
    const std::vector<std::uint8_t> bytes = developed_bytes(film, info, kChannels);
    const GdalDataset pixels =
        memory_dataset(byte_pixels(bytes, film.width_px(), film.height_px(), kChannels), watch);
    describe(pixels.get(), info, watch.attempt());
    GdalOptions options = {{"QUALITY", "95"}};
    const std::string encoded =
        encode_in_memory(pixels.get(), GDALGetDriverByName("JPEG"), options, watch);
    util::write_file_atomically(file, std::as_bytes(std::span(encoded)));
}

namespace {

constexpr int kWithAlpha = 4;

/// Where the samples of a film lie. Red, green, blue and alpha are the first four floats of each.
PixelsInMemory to_floats(const Film& film) {
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
        pixels = to_floats(film);
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

namespace {

constexpr std::array kEndings = {".exr", ".tif", ".tiff", ".png", ".jpg", ".jpeg"};
constexpr int kPngChannels = 3;

bool is_tiff(const std::filesystem::path& file) {
    const std::string ending = util::lower_extension(file);
    return ending == ".tif" || ending == ".tiff";
}

bool is_png(const std::filesystem::path& file) {
    return util::lower_extension(file) == ".png";
}

bool is_jpeg(const std::filesystem::path& file) {
    const std::string ending = util::lower_extension(file);
    return ending == ".jpg" || ending == ".jpeg";
}

/// @throws UsageError when it names no supported format
void check_ending(const std::filesystem::path& file) {
    const std::string ending = util::lower_extension(file);
    if (std::find(kEndings.begin(), kEndings.end(), ending) == kEndings.end())
        throw util::UsageError("write the picture " + file.string() + ": ending '" + ending +
                               "'; allowed: .png .jpg (8-bit), .exr .tif (float)");
}

/// Writes a band of rows at a time: writing must not double a picture's memory, and OpenEXR
/// compresses the rows of a band in parallel.
void write_exr(const Film& film, const std::filesystem::path& file, const PictureInfo& info) {
    constexpr int kBandRows = 128;
    const bool layers = film.has_layers() && info.layers;
    const ExrChannels channels(layers, info);
    ExrFile out(file, {film.width_px(), film.height_px()}, channels);
    std::vector<std::byte> band;
    for (int y0 = 0; y0 < film.height_px(); y0 += kBandRows) {
        const int y1 = std::min(y0 + kBandRows, film.height_px());
        band.resize(static_cast<std::size_t>(film.width_px()) * static_cast<std::size_t>(y1 - y0) *
                    channels.pixel_bytes());
        std::byte* to = band.data();
        for (int y = y0; y < y1; ++y)
            for (int x = 0; x < film.width_px(); ++x, to += channels.pixel_bytes())
                channels.put(film.at(x, y), layers ? &film.layers_at(x, y) : nullptr, to);
        out.write({0, y0, film.width_px(), y1, band.data()});
    }
    out.finish();
}

/// Other programs look for a description under the keyword of PNG's specification.
std::vector<png::Text> png_texts(const ImageMetadata& metadata) {
    std::vector<png::Text> out;
    for (const auto& [name, value] : metadata)
        out.push_back({name == "ImageDescription" ? "Description" : name, value});
    return out;
}

void write_png(const Film& film, const std::filesystem::path& file, const PictureInfo& info) {
    const std::vector<std::uint8_t> bytes = developed_bytes(film, info, kPngChannels);
    std::string encoded;
    try {
        encoded = png::encode(bytes, {film.width_px(), film.height_px(), kPngChannels},
                              png_texts(info.metadata));
    } catch (const util::Error& e) {
        throw util::Error("write the picture " + file.string() + ": " + e.what());
    }
    util::write_file_atomically(file, std::as_bytes(std::span(encoded)));
}

}  // namespace

bool is_exr(const std::filesystem::path& file) {
    return util::lower_extension(file) == ".exr";
}

void check_image_target(const std::filesystem::path& file, int width_px, int height_px) {
    check_ending(file);
    const std::string ending = util::lower_extension(file);
    const std::string attempt = "write the picture " + file.string() + ": ";
    constexpr const char* kLarger = "; .exr and .tif hold more";
    const std::string size = std::to_string(width_px) + "x" + std::to_string(height_px) + " pixels";
    if (is_jpeg(file) && std::max(width_px, height_px) > kMaxJpegSide_px)
        throw util::UsageError(attempt + size + "; allowed for " + ending + ": sides up to " +
                               std::to_string(kMaxJpegSide_px) + kLarger);
    const std::uint64_t most = png::kMaxBytes / kPngChannels;
    if (is_png(file) &&
        static_cast<std::uint64_t>(width_px) * static_cast<std::uint64_t>(height_px) > most)
        throw util::UsageError(attempt + size + "; allowed for .png: up to " +
                               std::to_string(most) + " in all" + kLarger);
    util::check_writable(file);
}

void write_image(const Film& film, const std::filesystem::path& file, const PictureInfo& given) {
    check_ending(file);
    const PictureInfo info = with_clean_texts(given);
    if (is_tiff(file))
        write_tiff(film, file, info);
    else if (is_png(file))
        write_png(film, file, info);
    else if (is_jpeg(file))
        write_jpeg(film, file, info);
    else
        write_exr(film, file, info);
}

}  // namespace terravox::output
