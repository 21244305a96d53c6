#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "common/voxel/colour.hpp"
#include "common/voxel/material.hpp"

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

/// Which orientations of a drawing may be used on a face, chosen by the voxel's hash so that
/// repetition does not show. The low three bits are those of PaintPoint::turn that the hash sets.
enum class Turn : std::uint8_t {
    kNone = 0,
    kMirror = 1,  ///< left and right may be exchanged
    kAny = 7,     ///< also up and down, and the two axes with each other
    /// t runs up a roof's slope; may be mirrored. The second half of the variants is for faces
    /// without a known slope.
    kSlope = 9,
};

inline constexpr int kLayouts = 4;

/// A drawing: several variants of 16 x 16 texels.
struct Drawing {
    void (*draw)(Canvas&, int variant) = nullptr;
    int variants = 1;
    Turn turn = Turn::kNone;
    /// Keeps its size of about one metre where voxels are finer: man-made patterns.
    bool metric = false;
    /// `variant % kLayouts` depends on the height alone, so that layers continue through all voxels
    /// of one height.
    bool layered = false;
};

/// The textures of a material's faces, under the name used in config/materials.toml.
struct Texture {
    std::string_view name;
    Drawing top;
    Drawing side;
    Drawing bottom;
    bool windows = false;  ///< on its side faces
    bool waves = false;    ///< on its top faces
    /// The material whose colour Dot::own is a ratio of; kAir: not used.
    voxel::Material own = voxel::Material::kAir;
};

/// All textures; the first is "none".
[[nodiscard]] std::span<const Texture> textures() noexcept;
/// @return the number of the texture, -1 if there is none of that name
[[nodiscard]] int texture_number(std::string_view name) noexcept;

// The drawings, by file. Variants differ in detail, never in what meets at the edges.
void draw_grass_top(Canvas&, int variant);
void draw_grass_side(Canvas&, int variant);
void draw_soil(Canvas&, int variant);
void draw_gravel(Canvas&, int variant);
void draw_rock_top(Canvas&, int variant);
void draw_rock_side(Canvas&, int variant);
void draw_sand(Canvas&, int variant);
void draw_snow(Canvas&, int variant);

void draw_tufts(Canvas&, int variant);
void draw_bush(Canvas&, int variant);
void draw_foliage(Canvas&, int variant);
void draw_hedge(Canvas&, int variant);
void draw_bark(Canvas&, int variant);
void draw_rings(Canvas&, int variant);

void draw_asphalt(Canvas&, int variant);
void draw_slabs(Canvas&, int variant);
void draw_ballast(Canvas&, int variant);
void draw_masonry(Canvas&, int variant);
void draw_planks(Canvas&, int variant);
void draw_paving(Canvas&, int variant);
void draw_plaster(Canvas&, int variant);
void draw_lattice(Canvas&, int variant);
void draw_wire_side(Canvas&, int variant);
void draw_wire_top(Canvas&, int variant);
void draw_panel(Canvas&, int variant);

void draw_tiles(Canvas&, int variant);
void draw_slate(Canvas&, int variant);
void draw_flat_roof(Canvas&, int variant);

}  // namespace terravox::material
