#pragma once

#include <cstdint>
#include <vector>

#include "raytracer/core/output/credit_line.hpp"
#include "raytracer/core/output/develop.hpp"
#include "raytracer/core/output/film.hpp"
#include "raytracer/core/output/picture_info.hpp"
#include "raytracer/core/tiles/tile.hpp"

namespace terravox::output {

/// Makes the pixels of an 8-bit picture: exposure, tone curve, credit line, dithering. Safe to
/// share between threads.
class PixelBytes {
public:
    PixelBytes(const PictureInfo& info, int width_px, int height_px)
        : m_develop(info.exposure_ev, info.tone), m_credit(info.credit, width_px, height_px) {}

    /// Writes red, green, blue.
    void put(const tiles::PixelSample& sample, int x, int y, std::uint8_t* rgb) const noexcept {
        const auto bytes = dithered_bytes(m_credit.over(m_develop(sample.colour), x, y), x, y);
        rgb[0] = bytes[0];
        rgb[1] = bytes[1];
        rgb[2] = bytes[2];
    }
    /// Writes red, green, blue, and alpha: the share of the pixel that shows the world; 1 under the
    /// credit line.
    void put_with_alpha(const tiles::PixelSample& sample, int x, int y,
                        std::uint8_t* rgba) const noexcept {
        put(sample, x, y, rgba);
        const float alpha = m_credit.covers(x, y) ? 1 : sample.alpha;
        rgba[3] = static_cast<std::uint8_t>(alpha >= 1 ? 255 : alpha > 0 ? alpha * 255 + 0.5f : 0);
    }

private:
    Developer m_develop;
    CreditLine m_credit;
};

/// All pixels of an 8-bit picture, row by row.
/// @param channels 3: red, green, blue; 4: and alpha
[[nodiscard]] std::vector<std::uint8_t> developed_bytes(const Film& film, const PictureInfo& info,
                                                        int channels);

}  // namespace terravox::output
