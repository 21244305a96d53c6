#pragma once

#include <cpl_error.h>
#include <gdal.h>
#include <ImathBox.h>
#include <ImathMatrix.h>
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <ImfMatrixAttribute.h>
#include <ImfStringAttribute.h>
#include <ImfTestFile.h>
#include <ImfTileDescription.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
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

inline PictureFile read_exr(const std::filesystem::path& file) {
    Imf::InputFile in(file.c_str());
    const Imf::Header& header = in.header();
    const Imath::Box2i area = header.dataWindow();
    PictureFile out;
    out.width = area.max.x - area.min.x + 1;
    out.height = area.max.y - area.min.y + 1;
    if (header.hasTileDescription()) {
        out.tile_width = static_cast<int>(header.tileDescription().xSize);
        out.tile_height = static_cast<int>(header.tileDescription().ySize);
    }
    // Red, green, blue and alpha first, as in other formats; OpenEXR lists them by the alphabet.
    for (const char* name : {"R", "G", "B", "A"})
        if (header.channels().findChannel(name) != nullptr)
            out.channels.push_back({name, {}});
    for (auto at = header.channels().begin(); at != header.channels().end(); ++at) {
        const std::string name = at.name();
        if (name != "R" && name != "G" && name != "B" && name != "A")
            out.channels.push_back({name, {}});
    }
    for (PictureFile::Channel& c : out.channels)
        c.type = header.channels()[c.name].type == Imf::HALF ? "half" : "float";
    for (auto at = header.begin(); at != header.end(); ++at) {
        const std::string name = at.name();
        if (const auto* text = dynamic_cast<const Imf::StringAttribute*>(&at.attribute()))
            out.texts[name == "owner"      ? "Copyright"
                      : name == "comments" ? "ImageDescription"
                                           : name] = text->value();
        if (const auto* matrix = dynamic_cast<const Imf::M44fAttribute*>(&at.attribute()))
            std::copy_n(&matrix->value()[0][0], 16, out.matrices[name].begin());
    }
    const std::size_t pixel = out.channels.size();
    out.pixels.resize(static_cast<std::size_t>(out.width) * static_cast<std::size_t>(out.height) *
                      pixel);
    Imf::FrameBuffer frame;
    for (std::size_t c = 0; c < pixel; ++c)
        frame.insert(out.channels[c].name,
                     Imf::Slice::Make(Imf::FLOAT, &out.pixels[c], area, pixel * sizeof(float),
                                      pixel * sizeof(float) * static_cast<std::size_t>(out.width)));
    in.setFrameBuffer(frame);
    in.readPixels(area.min.y, area.max.y);
    return out;
}

/// A name of output::ImageMetadata, from GDAL's.
inline std::string metadata_name(const std::string& name) {
    if (name == "TIFFTAG_IMAGEDESCRIPTION" || name == "Description")
        return "ImageDescription";
    if (name == "TIFFTAG_COPYRIGHT")
        return "Copyright";
    if (name == "TIFFTAG_SOFTWARE")
        return "Software";
    constexpr std::string_view kExif = "EXIF_";
    if (name.starts_with(kExif))
        return name.substr(kExif.size());
    constexpr std::string_view kOurs = "terravox_";  // with a colon, where GDAL allows one
    return name.starts_with(kOurs) ? "terravox:" + name.substr(kOurs.size()) : name;
}

inline PictureFile read_with_gdal(const std::filesystem::path& file) {
    // A program that registered drivers itself reads without the rules that inputs are subject to.
    if (GDALGetDriverCount() == 0)
        geo::start_gdal();
    const std::unique_ptr<void, void (*)(GDALDatasetH)> in(
        GDALOpen(file.c_str(), GA_ReadOnly), [](GDALDatasetH h) { (void)GDALClose(h); });
    if (!in)
        throw std::runtime_error("GDAL does not read " + file.string() + ": " +
                                 CPLGetLastErrorMsg());
    PictureFile out;
    out.width = GDALGetRasterXSize(in.get());
    out.height = GDALGetRasterYSize(in.get());
    const int count = GDALGetRasterCount(in.get());
    auto* const first = GDALGetRasterBand(in.get(), 1);
    GDALGetBlockSize(first, &out.tile_width, &out.tile_height);
    if (out.tile_width == out.width)
        out.tile_width = out.tile_height = 0;
    const bool bytes = GDALGetRasterDataType(first) == GDT_Byte;
    const std::map<GDALColorInterp, std::string> names = {
        {GCI_RedBand, "R"}, {GCI_GreenBand, "G"}, {GCI_BlueBand, "B"}, {GCI_AlphaBand, "A"}};
    for (int c = 1; c <= count; ++c) {
        const auto found =
            names.find(GDALGetRasterColorInterpretation(GDALGetRasterBand(in.get(), c)));
        out.channels.push_back({found != names.end() ? found->second : "band" + std::to_string(c),
                                bytes ? "uint8" : "float"});
    }
    const char* const* const items = GDALGetMetadata(in.get(), nullptr);
    for (int i = 0; items != nullptr && items[i] != nullptr; ++i) {
        const std::string item = items[i];
        const std::size_t end = item.find('=');
        if (end != std::string::npos)
            out.texts[metadata_name(item.substr(0, end))] = item.substr(end + 1);
    }
    out.pixels.resize(static_cast<std::size_t>(out.width) * static_cast<std::size_t>(out.height) *
                      static_cast<std::size_t>(count));
    constexpr GSpacing kFloat = sizeof(float);
    if (GDALDatasetRasterIOEx(in.get(), GF_Read, 0, 0, out.width, out.height, out.pixels.data(),
                              out.width, out.height, GDT_Float32, count, nullptr, kFloat * count,
                              kFloat * count * out.width, kFloat, nullptr) != CE_None)
        throw std::runtime_error("GDAL does not read the pixels of " + file.string());
    if (bytes)
        for (float& value : out.pixels)
            value /= 255;
    return out;
}

}  // namespace detail

/// @throws std::exception for a file that cannot be read
inline PictureFile read_picture(const std::filesystem::path& file) {
    return Imf::isOpenExrFile(file.c_str()) ? detail::read_exr(file) : detail::read_with_gdal(file);
}

}  // namespace terravox::test
