#include "raytracer/output/image_writer.hpp"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <array>
#include <memory>
#include <span>

#include "common/util/atomic_file.hpp"
#include "common/util/error.hpp"

namespace terravox {
namespace {

constexpr std::array kFloatEndings = {".exr", ".tif", ".tiff"};
constexpr std::array kByteEndings = {".png", ".jpg", ".jpeg"};

std::string ending_of(const std::filesystem::path& file) {
    std::string ending = file.extension().string();
    std::transform(ending.begin(), ending.end(), ending.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return ending;
}

template <class List> bool contains(const List& list, const std::string& value) { return std::find(list.begin(), list.end(), value) != list.end(); }

// The response of film without its toe: highlights roll off, shadows and hues stay as they are.
float photographic(float c) noexcept { return static_cast<float>(1 - det::exp(-static_cast<double>(c))); }

template <class Pixel> void write_rows(OIIO::ImageOutput& out, const Film& film, int channels, OIIO::TypeDesc type, const std::string& name, const Pixel& pixel) {
    // A band of rows at a time: a picture's memory must not double because it is written, and a format that compresses bands in
    // parallel can.
    constexpr int kBandRows = 128;
    const auto row_floats = static_cast<std::size_t>(film.width_px()) * static_cast<std::size_t>(channels);
    std::vector<float> band(row_floats * kBandRows);
    for (int y0 = 0; y0 < film.height_px(); y0 += kBandRows) {
        const int y1 = std::min(y0 + kBandRows, film.height_px());
        for (int y = y0; y < y1; ++y)
            for (int x = 0; x < film.width_px(); ++x)
                pixel(film.at(x, y), &band[static_cast<std::size_t>(y - y0) * row_floats + static_cast<std::size_t>(x) * static_cast<std::size_t>(channels)]);
        if (!out.write_scanlines(y0, y1, 0, type, band.data())) throw Error("write the picture " + name + ": " + out.geterror());
    }
}

}  // namespace

void check_image_target(const std::filesystem::path& file) {
    const std::string ending = ending_of(file);
    if (!contains(kFloatEndings, ending) && !contains(kByteEndings, ending))
        throw UsageError("write the picture " + file.string() + ": ending '" + ending + "'; allowed: .png .jpg (8-bit), .exr .tif (float)");
    util::check_writable(file);
}

Colour develop(Colour c, double exposure_ev, const std::string& tone) noexcept {
    constexpr double kLn2 = 0.693147180559945309417;
    // At exposure 0 a white wall in the sun lands at four fifths of the display's range.
    const double scale = tone == "photographic" ? 1.15 : 1.0;
    c = c * static_cast<float>(scale * det::exp(exposure_ev * kLn2));
    if (tone == "photographic") c = {photographic(c.r), photographic(c.g), photographic(c.b)};
    return {linear_to_srgb(c.r), linear_to_srgb(c.g), linear_to_srgb(c.b)};
}

void write_image(const Film& film, const std::filesystem::path& file, double exposure_ev, const std::string& tone, const ImageMetadata& metadata) {
    const std::string ending = ending_of(file), name = file.string();
    const bool exr = ending == ".exr", floats = contains(kFloatEndings, ending);
    OIIO::attribute("exr_threads", 0);  // one for each core
    auto out = OIIO::ImageOutput::create(name);
    if (!out) throw Error("write the picture " + name + ": " + OIIO::geterror());
    const int channels = exr ? 5 : floats ? 4 : 3;
    OIIO::ImageSpec spec(film.width_px(), film.height_px(), channels, floats ? OIIO::TypeDesc::FLOAT : OIIO::TypeDesc::UINT8);
    if (exr) spec.channelnames = {"R", "G", "B", "A", "Z"}, spec.z_channel = 4;
    if (floats) spec.alpha_channel = 3;
    spec.attribute("compression", exr ? "zip:2" : floats ? "zip" : "jpeg:95");
    spec.attribute("oiio:ColorSpace", floats ? "Linear" : "sRGB");
    for (const auto& [key, value] : metadata) spec.attribute(key, value);
    const auto write_all = [&](const std::string& path) {
        if (!out->open(path, spec)) throw Error("write the picture " + name + ": " + out->geterror());
        if (floats) {
            write_rows(*out, film, channels, OIIO::TypeDesc::FLOAT, name, [&](const PixelSample& p, float* v) {
                v[0] = p.colour.r, v[1] = p.colour.g, v[2] = p.colour.b, v[3] = p.alpha;
                if (exr) v[4] = p.depth_m;
            });
        } else {
            write_rows(*out, film, channels, OIIO::TypeDesc::FLOAT, name, [&](const PixelSample& p, float* v) {
                const Colour c = develop(p.colour, exposure_ev, tone);
                v[0] = c.r, v[1] = c.g, v[2] = c.b;
            });
        }
        if (!out->close()) throw Error("write the picture " + name + ": " + out->geterror());
    };
    if (floats) {
        util::AtomicFile target(file);
        write_all(target.temporary_path().string());
        target.commit();
        return;
    }
    // libpng's and libjpeg's writers do not tell when a disk is full (the second even ends the process), so these small files are
    // made in memory, and written by us.
    OIIO::Filesystem::IOVecOutput memory;
    if (!out->supports("ioproxy")) throw Error("write the picture " + name + ": this OpenImageIO cannot encode " + ending + " in memory");
    OIIO::Filesystem::IOProxy* proxy = &memory;
    spec.attribute("oiio:ioproxy", OIIO::TypeDesc::PTR, &proxy);
    write_all(name);
    util::write_file_atomically(file, std::as_bytes(std::span(memory.buffer())));
}

}  // namespace terravox
