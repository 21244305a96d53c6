#include "raytracer/output/film.hpp"

#include <algorithm>

namespace terravox {

Film::Film(int width_px, int height_px) : m_width(width_px), m_height(height_px), m_pixels(static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px)) {}

void Film::add(const TileResult& result) {
    std::size_t next = 0;
    const int step = result.tile.step;
    result.tile.each_pixel([&](int x, int y) {
        const PixelSample& sample = result.samples[next++];
        for (int py = y; py < std::min(y + step, m_height); ++py)
            for (int px = x; px < std::min(x + step, m_width); ++px) m_pixels[index(px, py)] = sample;
    });
}

}  // namespace terravox
