#include "raytracer/core/output/pixel_bytes.hpp"

namespace terravox::output {

std::vector<std::uint8_t> developed_bytes(const Film& film, const PictureInfo& info, int channels) {
    const int width = film.width_px();
    const int height = film.height_px();
    const PixelBytes make(info, width, height);
    std::vector<std::uint8_t> out(static_cast<std::size_t>(width) *
                                  static_cast<std::size_t>(height) *
                                  static_cast<std::size_t>(channels));
    std::uint8_t* to = out.data();
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x, to += channels) {
            if (channels == 4)
                make.put_with_alpha(film.at(x, y), x, y, to);
            else
                make.put(film.at(x, y), x, y, to);
        }
    return out;
}

}  // namespace terravox::output
