#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/voxel/colour.hpp"
#include "raytracer/core/base/scene_words.hpp"
#include "raytracer/core/output/credit_line.hpp"
#include "raytracer/core/output/picture.hpp"
#include "raytracer/core/tiles/tile.hpp"

namespace terravox::output {

/// Converts linear light to display values with exposure and a tone curve. The curves:
///   photographic  1 - e^-c for each primary: highlights roll off, shadows stay as they are; bright
///                 colours stay strong
///   filmic        with a toe and a shoulder that ends in white 1.9 stops above a white wall in the
///                 sun. Ref: Hable, "Filmic Tonemapping for Real-time Rendering", SIGGRAPH 2010
///   agx           primaries are drawn in towards white, a sigmoid over log2 of light from 10 stops
///                 below middle grey to 6.5 above, and primaries drawn out again: bright colours
///                 pale towards white and keep their hue. Ref: Sobotka, "AgX", 2022
///   linear        cut off at 1
/// Middle grey is the same for all to a quarter of a stop. Greys stay grey, more light never gives
/// a darker grey, 0 gives 0, and all light gives at most 1. The same bits on every machine. Cheap
/// to copy, safe to share between threads.
class Developer {
public:
    Developer(double exposure_ev, core::ToneCurve tone);
    /// @param linear any values; negative ones and NaN count as 0
    /// @return sRGB in [0, 1]
    [[nodiscard]] voxel::Colour operator()(voxel::Colour linear) const noexcept;

private:
    float m_scale;
    const class ToneTable* m_curve;
    bool m_agx;
};

/// One pixel through a temporary Developer.
[[nodiscard]] voxel::Colour develop(voxel::Colour linear, double exposure_ev, core::ToneCurve tone);

/// Converts sRGB in [0, 1] to bytes with dithering. A value between two bytes is rounded up with a
/// frequency equal to its fraction (a hash of the position decides, the same for the three
/// primaries), so that skies show no banding. 0, 1 and exact bytes are unchanged.
[[nodiscard]] std::array<std::uint8_t, 3> dithered_bytes(voxel::Colour display, int x,
                                                         int y) noexcept;

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
