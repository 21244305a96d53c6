#include "voxelserver/map/png.hpp"

#include <png.h>

#include "common/util/error.hpp"

namespace terravox::map {

// libpng's "simplified" interface catches its own long jumps, so that none crosses C++ frames, and
// compresses at zlib's default level, 6.
std::string png_of(std::span<const Rgba8> pixels, int width, int height) {
    constexpr int kMaxSide = 8192;
    const auto fail = [&](const std::string& what) -> void {
        throw util::Error("write a PNG of " + std::to_string(width) + " x " +
                          std::to_string(height) + " pixels: " + what);
    };
    if (width < 1 || height < 1 || width > kMaxSide || height > kMaxSide)
        fail("allowed: 1 to " + std::to_string(kMaxSide) + " a side");
    if (pixels.size() != static_cast<std::size_t>(width) * static_cast<std::size_t>(height))
        fail(std::to_string(pixels.size()) + " pixels were given");

    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    image.width = static_cast<png_uint_32>(width);
    image.height = static_cast<png_uint_32>(height);
    image.format = PNG_FORMAT_RGBA;
    // Sufficient for incompressible pixels: one pass is enough.
    png_alloc_size_t bytes = PNG_IMAGE_PNG_SIZE_MAX(image);
    std::string out(bytes, '\0');
    const int written =
        png_image_write_to_memory(&image, out.data(), &bytes, 0, pixels.data(), 0, nullptr);
    const std::string message = image.message;
    png_image_free(&image);
    if (written == 0)
        fail(message);
    out.resize(bytes);
    out.shrink_to_fit();
    return out;
}

}  // namespace terravox::map
