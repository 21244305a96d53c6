#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/voxel/colour.hpp"

namespace terravox::material {

inline constexpr int kTexels = 16;  ///< along each edge of a texture

/// A texel while it is being drawn. See Texel.
struct Dot {
    voxel::Colour ratio{1, 1, 1};
    voxel::Colour own{1, 1, 1};
    float share = 0;    ///< of `own`, [0, 1]
    float opacity = 1;  ///< [0, 1]
};

/// The surface that a texture is drawn on: s to the right, t up (of a top face: s east, t south; of
/// a roof: t up the slope). Coordinates wrap around at its edges.
class Canvas {
public:
    [[nodiscard]] Dot& at(int s, int t) noexcept { return m_dots[index(s, t)]; }
    [[nodiscard]] const Dot& at(int s, int t) const noexcept { return m_dots[index(s, t)]; }
    /// Calls draw(dot, s, t) for every texel, row by row.
    template <class Draw>
    void each(const Draw& draw) {
        for (int t = 0; t < kTexels; ++t)
            for (int s = 0; s < kTexels; ++s)
                draw(at(s, t), s, t);
    }

private:
    [[nodiscard]] static std::size_t index(int s, int t) noexcept {
        return static_cast<std::size_t>((t & (kTexels - 1)) * kTexels + (s & (kTexels - 1)));
    }
    std::array<Dot, kTexels * kTexels> m_dots;
};

/// Noise in [0, 1), a pure function of its arguments.
[[nodiscard]] float chance(int a, int b, std::uint64_t seed) noexcept;
/// Noise in [-1, 1), one value for each texel; wraps around.
[[nodiscard]] float grain(int s, int t, std::uint64_t seed) noexcept;
/// Smooth noise in [-1, 1]; wraps around.
/// @param cells along each edge: 2, 4 or 8
[[nodiscard]] float cloud(int s, int t, int cells, std::uint64_t seed) noexcept;
/// Cosine-like wave of period 1, from -1 to 1, made of parabolas.
[[nodiscard]] float wave(float turns) noexcept;
/// A tint: factors of red, green and blue around 1.
/// @param warm [-1, 1]: towards blue (-1) or towards red and yellow (1)
[[nodiscard]] voxel::Colour tint(float brightness, float warm) noexcept;

/// A partition of the plane into cells around jittered points, with gaps: cobbles, gravel, cracks.
/// Wraps around. Ref: Worley, "A cellular texture basis function", SIGGRAPH 1996.
class Stones {
public:
    struct At {
        int id = 0;      ///< of the stone
        float edge = 0;  ///< distance to its border, texels
        float up = 0;    ///< height above its middle, texels
    };
    /// @param per_edge number of stones along each edge of the canvas
    Stones(int per_edge, std::uint64_t seed);
    [[nodiscard]] At at(int s, int t) const noexcept;

private:
    std::vector<std::array<float, 2>> m_points;
};

}  // namespace terravox::material
