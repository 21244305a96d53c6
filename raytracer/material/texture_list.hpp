#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "common/voxel/material.hpp"
#include "raytracer/material/canvas.hpp"

namespace terravox::material {

/// How a drawing may be laid on a face, chosen by the voxel's hash, so that its repetition does not
/// show. Its low three bits are those of PaintPoint::turn that the hash sets.
enum class Turn : std::uint8_t {
    kNone = 0,
    kMirror = 1,  ///< left and right change places
    kAny = 7,     ///< and up and down, and both with each other
    kSlope = 9,  ///< its t runs up a roof's slope; mirrored. The second half of its variants is for
                 ///< faces that tell no slope.
};

inline constexpr int kLayouts = 4;

/// A drawing: some variants of 16 x 16 texels.
struct Drawing {
    void (*draw)(Canvas&, int variant) = nullptr;
    int variants = 1;
    Turn turn = Turn::kNone;
    bool metric = false;   ///< keeps to about one metre where voxels are finer: what people built
    bool layered = false;  ///< `variant % kLayouts` goes by height alone, so that layers run
                           ///< through all voxels of a height
};

/// What the faces of a material show, under the name that stands in config/materials.toml.
struct Texture {
    std::string_view name;
    Drawing top, side, bottom;
    bool windows = false;  ///< on its side faces
    bool waves = false;    ///< on its top faces
    voxel::Material own =
        voxel::Material::kAir;  ///< whose colour Dot::own is a ratio of; kAir: none is used
};

/// All textures; the first is "none".
[[nodiscard]] std::span<const Texture> textures() noexcept;
/// @return the texture's number, -1 when there is no such one
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
