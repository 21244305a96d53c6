#include "raytracer/core/output/image_writer.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "common/png/png.hpp"
#include "common/util/atomic_file.hpp"
#include "common/util/error.hpp"
#include "common/util/letter_case.hpp"
#include "raytracer/core/output/exr_channels.hpp"
#include "raytracer/core/output/exr_file.hpp"
#include "raytracer/core/output/jpeg_picture.hpp"
#include "raytracer/core/output/pixel_bytes.hpp"
#include "raytracer/core/output/tiff_picture.hpp"

namespace terravox::output {
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
