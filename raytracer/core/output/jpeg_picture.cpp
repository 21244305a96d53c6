#include "raytracer/core/output/jpeg_picture.hpp"

#include <span>
#include <string>

#include "common/util/atomic_file.hpp"
#include "common/util/log.hpp"
#include "raytracer/core/output/gdal_writing.hpp"
#include "raytracer/core/output/pixel_bytes.hpp"

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

}  // namespace terravox::output
