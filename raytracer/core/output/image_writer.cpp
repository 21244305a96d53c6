#include "raytracer/core/output/image_writer.hpp"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/png/png.hpp"
#include "common/util/atomic_file.hpp"
#include "common/util/error.hpp"
#include "common/util/log.hpp"
#include "common/util/text.hpp"
#include "raytracer/core/output/develop.hpp"
#include "raytracer/core/output/exr_channels.hpp"
#include "raytracer/core/output/gdal_writing.hpp"
#include "raytracer/core/output/picture_file.hpp"

namespace terravox::output {
namespace {

constexpr int kChannels = 3;

enum class WrittenBy { kPng, kGdal, kOpenImageIO };

struct PictureFormat {
    std::string_view ending;
    bool has_floats;
    WrittenBy by;
    int max_side_px;          ///< 0: any
    const char* compression;  ///< FileShape::compression
    bool is_everywhere;       ///< every OpenImageIO writes it
};
using enum WrittenBy;
constexpr PictureFormat kFormats[] = {
    {".png", false, kPng, 0, "", true},
    {".jpg", false, kOpenImageIO, 65500, "jpeg:95", true},
    {".jpeg", false, kOpenImageIO, 65500, "jpeg:95", true},
    {".dpx", false, kOpenImageIO, 0, "", false},
    {".jxl", false, kOpenImageIO, 0, "jpegxl:95", false},
    {".tga", false, kOpenImageIO, 65535, "rle", false},
    {".webp", false, kOpenImageIO, 16383, "webp:95", false},
    // Level 2 is faster than the usual 4, for somewhat larger files.
    {".exr", true, kOpenImageIO, 0, "zip:2", true},
    {".tif", true, kGdal, 0, "", true},
    {".tiff", true, kGdal, 0, "", true},
    {".hdr", true, kOpenImageIO, 0, "", false},
};

bool is_available(const PictureFormat& format) {
    return format.by != kOpenImageIO || can_encode(std::string(format.ending));
}

/// The endings of formats for messages, " .png .jpg".
std::string list_endings(bool has_floats) {
    std::string out;
    for (const PictureFormat& format : kFormats)
        if (format.has_floats == has_floats && format.ending != ".jpeg" &&
            format.ending != ".tiff" && (format.is_everywhere || is_available(format)))
            out += " " + std::string(format.ending);
    return out;
}

/// @throws UsageError when it names no supported format
const PictureFormat& find_format(const std::filesystem::path& file) {
    const std::string ending = util::lower_extension(file);
    const auto* const found = std::ranges::find(kFormats, ending, &PictureFormat::ending);
    if (found == std::end(kFormats) || !is_available(*found))
        throw util::UsageError("write the picture " + file.string() + ": ending '" + ending +
                               "'; allowed:" + list_endings(false) + " (8-bit)," +
                               list_endings(true) + " (float)");
    return *found;
}

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
        options.add({{"ALPHA", "PREMULTIPLIED"}});  // as in EXR
    GdalDataset out(GDALCreateCopy(GDALGetDriverByName("GTiff"), file.string().c_str(), from, FALSE,
                                   options.List(), nullptr, nullptr));
    watch.check(out != nullptr);
    out.reset();  // writes what is left
    watch.check_closed_tiff(file);
}

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

/// Writes a band of rows at a time: writing must not double a picture's memory, and OpenEXR
/// compresses the rows of a band in parallel.
/// @param put (x, y, where the bytes of that pixel belong)
template <class Put>
void write_rows(PictureFile& out, const Film& film, std::size_t pixel_bytes, const Put& put) {
    constexpr int kBandRows = 128;
    std::vector<std::byte> band;
    for (int y0 = 0; y0 < film.height_px(); y0 += kBandRows) {
        const int y1 = std::min(y0 + kBandRows, film.height_px());
        band.resize(static_cast<std::size_t>(film.width_px()) * static_cast<std::size_t>(y1 - y0) *
                    pixel_bytes);
        std::byte* to = band.data();
        for (int y = y0; y < y1; ++y)
            for (int x = 0; x < film.width_px(); ++x, to += pixel_bytes)
                put(x, y, to);
        out.write({0, y0, film.width_px(), y1, band.data()});
    }
    out.finish();
}

void write_exr(const Film& film, const std::filesystem::path& file, const PictureInfo& info,
               const char* compression) {
    const bool layers = film.has_layers() && info.layers;
    const ExrChannels channels(layers, info);
    PictureFile out(file, {film.width_px(), film.height_px(), channels.list(), compression},
                    channels.info());
    write_rows(out, film, channels.pixel_bytes(), [&](int x, int y, std::byte* to) {
        channels.put(film.at(x, y), layers ? &film.layers_at(x, y) : nullptr, to);
    });
}

/// The texts for which other formats than EXR have a place. All of Exif has room for 64 KiB, and
/// libjpeg ends the process when that does not suffice.
PictureInfo with_exif_texts(const PictureInfo& info, const std::string& attempt) {
    constexpr std::size_t kMaxBytes = 16384;
    PictureInfo out;
    for (auto [name, text] : info.metadata) {
        if (name != "Software" && name != "Copyright" && name != "ImageDescription")
            continue;
        if (std::size_t end = kMaxBytes; text.size() > end) {
            util::log_warn("{}: of {} only the first {} bytes are stored", attempt, name, end);
            // Not in the middle of a character of UTF-8.
            while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0U) == 0x80U)
                --end;
            text.resize(end);
        }
        out.metadata.emplace_back(name, text);
    }
    return out;
}

void write_simple(const Film& film, const std::filesystem::path& file, const PictureInfo& info,
                  const PictureFormat& format) {
    const SampleType type = format.has_floats ? SampleType::kFloat : SampleType::kByte;
    PictureFile out(file,
                    {film.width_px(),
                     film.height_px(),
                     {{"R", type}, {"G", type}, {"B", type}},
                     format.compression},
                    with_exif_texts(info, "write the picture " + file.string()));
    if (format.has_floats) {
        const auto put = [&](int x, int y, std::byte* to) {
            std::memcpy(to, &film.at(x, y).colour, kChannels * sizeof(float));
        };
        return write_rows(out, film, kChannels * sizeof(float), put);
    }
    const PixelBytes bytes(info, film.width_px(), film.height_px());
    write_rows(out, film, kChannels, [&](int x, int y, std::byte* to) {
        bytes.put(film.at(x, y), x, y, reinterpret_cast<std::uint8_t*>(to));
    });
}

/// Other programs look for a description under the keyword of PNG's specification.
std::vector<png::Text> png_texts(const ImageMetadata& metadata) {
    std::vector<png::Text> out;
    for (const auto& [name, value] : metadata)
        out.push_back({name == "ImageDescription" ? "Description" : name, value});
    return out;
}

void write_png(const Film& film, const std::filesystem::path& file, const PictureInfo& info) {
    const std::vector<std::uint8_t> bytes = developed_bytes(film, info, kChannels);
    std::string encoded;
    try {
        encoded = png::encode(bytes, {film.width_px(), film.height_px(), kChannels},
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
    const PictureFormat& format = find_format(file);
    const std::string attempt = "write the picture " + file.string() + ": ";
    constexpr const char* kLarger = "; .exr and .tif hold more";
    const std::string size = std::to_string(width_px) + "x" + std::to_string(height_px) + " pixels";
    if (format.max_side_px > 0 && std::max(width_px, height_px) > format.max_side_px)
        throw util::UsageError(attempt + size + "; allowed for " + util::lower_extension(file) +
                               ": sides up to " + std::to_string(format.max_side_px) + kLarger);
    const std::uint64_t most = png::kMaxBytes / kChannels;
    if (format.by == kPng &&
        static_cast<std::uint64_t>(width_px) * static_cast<std::uint64_t>(height_px) > most)
        throw util::UsageError(attempt + size + "; allowed for .png: up to " +
                               std::to_string(most) + " in all" + kLarger);
    util::check_writable(file);
}

void write_image(const Film& film, const std::filesystem::path& file, const PictureInfo& given) {
    const PictureFormat& format = find_format(file);
    const PictureInfo info = with_clean_texts(given);
    if (format.by == kGdal)
        write_tiff(film, file, info);
    else if (format.by == kPng)
        write_png(film, file, info);
    else if (format.ending == ".exr")
        write_exr(film, file, info, format.compression);
    else
        write_simple(film, file, info, format);
}

}  // namespace terravox::output
