#include "raytracer/core/output/picture.hpp"

#include <algorithm>
#include <string_view>

#include "common/util/text.hpp"

namespace terravox::output {
namespace {

std::string clean(std::string_view text) {
    constexpr std::string_view kKept = "\n\t";
    std::string out;
    while (true) {
        const std::size_t end = text.find_first_of(kKept);
        out += util::printable(text.substr(0, end));
        if (end == std::string_view::npos)
            return out;
        out += text[end];
        text.remove_prefix(end + 1);
    }
}

}  // namespace

PictureInfo with_clean_texts(PictureInfo info) {
    for (auto& [name, value] : info.metadata)
        value = clean(value);
    return info;
}

Film::Film(int width_px, int height_px, bool with_layers)
    : m_width(width_px),
      m_height(height_px),
      m_pixels(static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px)),
      m_layers(with_layers ? m_pixels.size() : 0) {}

void Film::add(const tiles::TileResult& result) {
    std::size_t next = 0;
    const int step = result.tile.step;
    result.tile.each_pixel([&](int x, int y) {
        const std::size_t own = next++;
        const tiles::PixelSample& sample = result.samples[own];
        for (int py = y; py < std::min(y + step, m_height); ++py)
            for (int px = x; px < std::min(x + step, m_width); ++px) {
                tiles::PixelSample& pixel = m_pixels[index(px, py)];
                if (result.tile.first_sample == 0) {
                    pixel = sample;
                    if (has_layers())
                        m_layers[index(px, py)] = result.layers[own];
                    continue;
                }
                const auto count = [](const tiles::PixelSample& s) {
                    return static_cast<float>(s.samples);
                };
                if (has_layers())
                    m_layers[index(px, py)].merge(result.layers[own], count(pixel), count(sample),
                                                  count(pixel) * pixel.alpha,
                                                  count(sample) * sample.alpha);
                pixel.merge(sample);
            }
    });
}

bool Film::error_above(const tiles::RenderTile& tile, double share) const noexcept {
    for (int y = tile.y0; y < tile.y1; ++y)
        for (int x = tile.x0; x < tile.x1; ++x)
            if (!at(x, y).is_known(share))
                return true;
    return false;
}

}  // namespace terravox::output
