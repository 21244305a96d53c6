#include "raytracer/output/image_writer.hpp"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <memory>
#include <span>

#include "common/geo/gdal_error_scope.hpp"
#include "common/util/atomic_file.hpp"
#include "common/util/error.hpp"
#include "common/util/letter_case.hpp"
#include "raytracer/output/checked_file.hpp"
#include "raytracer/output/exr_channels.hpp"
#include "raytracer/output/gdal_writing.hpp"
#include "raytracer/output/geotiff.hpp"
#include "raytracer/output/pixel_bytes.hpp"

namespace terravox::output {
namespace {

constexpr std::array kFloatEndings = {".exr", ".tif", ".tiff"};
constexpr std::array kByteEndings = {".png", ".jpg", ".jpeg"};

bool is_tiff(const std::filesystem::path& file) {
    return util::lower_extension(file).starts_with(".tif");
}

template <class List>
bool contains(const List& list, const std::string& value) {
    return std::find(list.begin(), list.end(), value) != list.end();
}

/// Writes a band of rows at a time: writing must not double a picture's memory, and a format that
/// compresses bands in parallel can do so.
/// @param pixel (x, y, destination of its bytes)
template <class Pixel>
void write_rows(OIIO::ImageOutput& out, const Film& film, OIIO::TypeDesc type,
                std::size_t pixel_bytes, const std::string& name, const Pixel& pixel) {
    constexpr int kBandRows = 128;
    const std::size_t row_bytes = static_cast<std::size_t>(film.width_px()) * pixel_bytes;
    std::vector<std::byte> band(row_bytes * kBandRows);
    for (int y0 = 0; y0 < film.height_px(); y0 += kBandRows) {
        const int y1 = std::min(y0 + kBandRows, film.height_px());
        for (int y = y0; y < y1; ++y)
            for (int x = 0; x < film.width_px(); ++x)
                pixel(x, y,
                      &band[static_cast<std::size_t>(y - y0) * row_bytes +
                            static_cast<std::size_t>(x) * pixel_bytes]);
        if (!out.write_scanlines(y0, y1, 0, type, band.data()))
            throw util::Error("write the picture " + name + ": " + out.geterror());
    }
}

/// One picture on its way to one file.
struct Writing {
    const Film& film;
    const PictureInfo& info;
    std::string name;
    std::unique_ptr<OIIO::ImageOutput> out;

    Writing(const Film& from, const std::filesystem::path& file, const PictureInfo& what)
        : film(from), info(what), name(file.string()), out(OIIO::ImageOutput::create(name)) {
        if (!out)
            throw util::Error("write the picture " + name + ": " + OIIO::geterror());
    }
    template <class Pixel>
    void write(const std::string& path, const OIIO::ImageSpec& spec, OIIO::TypeDesc type,
               std::size_t pixel_bytes, const Pixel& pixel) const {
        if (!out->open(path, spec))
            throw util::Error("write the picture " + name + ": " + out->geterror());
        write_rows(*out, film, type, pixel_bytes, name, pixel);
        if (!out->close())
            throw util::Error("write the picture " + name + ": " + out->geterror());
    }
};

void write_exr(const Film& film, const std::filesystem::path& file, const PictureInfo& info) {
    const Writing writing(film, file, info);
    const bool layers = film.has_layers() && info.layers;
    const ExrChannels channels(layers, info);
    OIIO::ImageSpec spec(film.width_px(), film.height_px(), 4, OIIO::TypeDesc::FLOAT);
    channels.describe(spec);
    spec.attribute("compression", "zip:2");
    util::AtomicFile target(file);
    CheckedFile checked(target.temporary_path(), "write the picture " + file.string());
    checked.attach_to(spec);
    writing.write(target.temporary_path().string(), spec, OIIO::TypeDesc::UNKNOWN,
                  channels.pixel_bytes(), [&](int x, int y, std::byte* to) {
                      channels.put(film.at(x, y), layers ? &film.layers_at(x, y) : nullptr, to);
                  });
    checked.close();
    target.commit();
}

// OpenImageIO does not report when the end of a file does not fit on the disk.
void check_closed_tiff(const util::AtomicFile& written, const std::filesystem::path& file) {
    const GdalWatch watch("write the picture " + file.string());
    watch.check_closed_tiff(written.temporary_path());
}

void write_float_tiff(const Film& film, const std::filesystem::path& file,
                      const PictureInfo& info) {
    const geo::GdalErrorScope errors;
    const Writing writing(film, file, info);
    OIIO::ImageSpec spec(film.width_px(), film.height_px(), 4, OIIO::TypeDesc::FLOAT);
    spec.alpha_channel = 3;
    spec.attribute("compression", "zip");
    spec.attribute("oiio:ColorSpace", "Linear");
    for (const auto& [key, value] : info.metadata)
        spec.attribute(key, value);
    util::AtomicFile target(file);
    writing.write(target.temporary_path().string(), spec, OIIO::TypeDesc::FLOAT, 4 * sizeof(float),
                  [&](int x, int y, std::byte* to) {
                      const tiles::PixelSample& p = film.at(x, y);
                      const std::array<float, 4> rgba = {p.colour.r, p.colour.g, p.colour.b,
                                                         p.alpha};
                      std::memcpy(to, rgba.data(), sizeof rgba);
                  });
    check_closed_tiff(target, file);
    target.commit();
}

void write_bytes(const Film& film, const std::filesystem::path& file, const PictureInfo& info) {
    const geo::GdalErrorScope errors;
    const Writing writing(film, file, info);
    OIIO::ImageSpec spec(film.width_px(), film.height_px(), 3, OIIO::TypeDesc::UINT8);
    spec.attribute("compression", is_tiff(file) ? "zip" : "jpeg:95");
    spec.attribute("oiio:ColorSpace", "sRGB");
    for (const auto& [key, value] : info.metadata)
        spec.attribute(key, value);
    const PixelBytes bytes(info, film.width_px(), film.height_px());
    const auto write_all = [&](const std::string& path) {
        writing.write(path, spec, OIIO::TypeDesc::UINT8, 3, [&](int x, int y, std::byte* to) {
            bytes.put(film.at(x, y), x, y, reinterpret_cast<std::uint8_t*>(to));
        });
    };
    if (is_tiff(file)) {
        util::AtomicFile target(file);
        write_all(target.temporary_path().string());
        check_closed_tiff(target, file);
        target.commit();
        return;
    }
    // libpng's and libjpeg's writers do not report a full disk (the second even ends the process),
    // so these small files are made in memory, and written here.
    OIIO::Filesystem::IOVecOutput memory;
    if (!writing.out->supports("ioproxy"))
        throw util::Error("write the picture " + writing.name +
                          ": this OpenImageIO cannot encode " + util::lower_extension(file) +
                          " in memory");
    OIIO::Filesystem::IOProxy* proxy = &memory;
    spec.attribute("oiio:ioproxy", OIIO::TypeDesc::PTR, &proxy);
    write_all(writing.name);
    util::write_file_atomically(file, std::as_bytes(std::span(memory.buffer())));
}

}  // namespace

bool is_exr(const std::filesystem::path& file) {
    return util::lower_extension(file) == ".exr";
}

void check_image_target(const std::filesystem::path& file) {
    const std::string ending = util::lower_extension(file);
    if (!contains(kFloatEndings, ending) && !contains(kByteEndings, ending))
        throw util::UsageError("write the picture " + file.string() + ": ending '" + ending +
                               "'; allowed: .png .jpg (8-bit), .exr .tif (float)");
    util::check_writable(file);
}

void write_image(const Film& film, const std::filesystem::path& file, const PictureInfo& info) {
    OIIO::attribute("exr_threads", 0);  // one for each core
    if (!is_tiff(file) && contains(kFloatEndings, util::lower_extension(file)))
        return write_exr(film, file, info);
    if (is_tiff(file) && info.geo)
        return write_geotiff(film, file, info);
    if (is_tiff(file) && info.tiff_holds_floats())
        return write_float_tiff(film, file, info);
    write_bytes(film, file, info);
}

}  // namespace terravox::output
