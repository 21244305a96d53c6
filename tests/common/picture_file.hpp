#pragma once

#include <gdal.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "common/geo/gdal.hpp"

namespace terravox::test {

/// All that a picture file contains, of any format that terravox writes.
struct PictureFile {
    struct Channel {
        std::string name;
        std::string type;  ///< "half", "float" or "uint8"
    };
    int width = 0;
    int height = 0;
    int tile_width = 0;  ///< 0: in rows
    int tile_height = 0;
    std::vector<Channel> channels;
    std::map<std::string, std::string> texts;  ///< by the names of output::ImageMetadata
    std::map<std::string, std::array<float, 16>> matrices;
    /// Row by row, the channels of a pixel side by side; bytes from 0 to 1.
    std::vector<float> pixels;

    [[nodiscard]] std::size_t channel(const std::string& name) const {
        const auto found = std::find_if(channels.begin(), channels.end(),
                                        [&](const Channel& c) { return c.name == name; });
        if (found == channels.end())
            throw std::runtime_error("no channel " + name);
        return static_cast<std::size_t>(found - channels.begin());
    }
    [[nodiscard]] float at(int x, int y, std::size_t c) const {
        return pixels[(static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                       static_cast<std::size_t>(x)) *
                          channels.size() +
                      c];
    }
    [[nodiscard]] float at(int x, int y, const std::string& name) const {
        return at(x, y, channel(name));
    }
    [[nodiscard]] std::vector<std::string> names() const {
        std::vector<std::string> out;
        for (const Channel& c : channels)
            out.push_back(c.name);
        return out;
    }
    /// Empty where there is none.
    [[nodiscard]] std::string text(const std::string& name) const {
        const auto found = texts.find(name);
        return found == texts.end() ? std::string() : found->second;
    }
};

namespace detail {

/// A name of output::ImageMetadata, from GDAL's or OpenImageIO's.
inline std::string metadata_name(std::string_view name) {
    if (name == "worldtocamera")
        return "worldToCamera";
    if (name == "worldtoNDC")
        return "worldToNDC";
    for (const std::string_view prefix : {"Exif:", "openexr:"})
        if (name.starts_with(prefix))
            name.remove_prefix(prefix.size());
    constexpr std::string_view kOurs = "terravox_";  // with a colon, where GDAL allows one
    return name.starts_with(kOurs) ? "terravox:" + std::string(name.substr(kOurs.size()))
                                   : std::string(name);
}

/// Texts that are GDAL's own in a TIFF.
inline void add_gdal_texts(const std::filesystem::path& file, PictureFile& out) {
    // A program that registered drivers itself reads without the rules that inputs are subject to.
    if (GDALGetDriverCount() == 0)
        geo::start_gdal();
    const std::unique_ptr<void, void (*)(GDALDatasetH)> in(
        GDALOpen(file.c_str(), GA_ReadOnly), [](GDALDatasetH h) { (void)GDALClose(h); });
    const char* const* items = in ? GDALGetMetadata(in.get(), nullptr) : nullptr;
    for (; items != nullptr && *items != nullptr; ++items) {
        const std::string_view item = *items;
        const std::size_t end = item.find('=');
        if (item.starts_with("terravox_") && end != std::string_view::npos)
            out.texts[metadata_name(item.substr(0, end))] = item.substr(end + 1);
    }
}

}  // namespace detail

/// @throws std::exception for a file that cannot be read
inline PictureFile read_picture(const std::filesystem::path& file) {
    OIIO::ImageSpec as_stored;
    as_stored.attribute("oiio:UnassociatedAlpha", 1);
    const auto in = OIIO::ImageInput::open(file.string(), &as_stored);
    if (!in)
        throw std::runtime_error("OpenImageIO does not read " + file.string() + ": " +
                                 OIIO::geterror());
    const OIIO::ImageSpec& spec = in->spec();
    PictureFile out;
    out.width = spec.width;
    out.height = spec.height;
    out.tile_width = spec.tile_width;
    out.tile_height = spec.tile_height;
    for (int c = 0; c < spec.nchannels; ++c)
        out.channels.push_back({spec.channel_name(c), spec.channelformat(c).c_str()});
    for (const auto& item : spec.extra_attribs) {
        const std::string name = detail::metadata_name(item.name().string());
        if (item.type() == OIIO::TypeMatrix)
            std::copy_n(static_cast<const float*>(item.data()), 16, out.matrices[name].begin());
        else if (item.type() == OIIO::TypeString || name == "ColorSpace")
            out.texts[name] = item.get_string();
    }
    if (in->format_name() == std::string_view("tiff"))
        detail::add_gdal_texts(file, out);
    out.pixels.resize(static_cast<std::size_t>(spec.image_pixels()) * out.channels.size());
    if (!in->read_image(0, 0, 0, spec.nchannels, OIIO::TypeFloat, out.pixels.data()))
        throw std::runtime_error("OpenImageIO does not read the pixels of " + file.string() + ": " +
                                 in->geterror());
    return out;
}

}  // namespace terravox::test
