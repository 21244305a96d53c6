#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "common/voxel/material.hpp"
#include "raytracer/core/material/canvas.hpp"

namespace terravox::material {

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
