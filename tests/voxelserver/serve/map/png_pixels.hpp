#pragma once

#include <png.h>

#include <stdexcept>
#include <string>
#include <vector>

#include "voxelserver/serve/map/pixels.hpp"

namespace terravox::test {

struct PngPixels {
    int width = 0;
    int height = 0;
    std::vector<map::Rgba8> pixels;
};

inline PngPixels read_png(const std::string& bytes) {
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    if (png_image_begin_read_from_memory(&image, bytes.data(), bytes.size()) == 0)
        throw std::runtime_error(image.message);
    image.format = PNG_FORMAT_RGBA;
    PngPixels out{static_cast<int>(image.width), static_cast<int>(image.height), {}};
    out.pixels.resize(std::size_t{image.width} * image.height);
    if (png_image_finish_read(&image, nullptr, out.pixels.data(), 0, nullptr) == 0)
        throw std::runtime_error(image.message);
    return out;
}

}  // namespace terravox::test
