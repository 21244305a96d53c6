#pragma once

#include <array>
#include <cstdint>

#include "common/voxel/colour.hpp"
#include "raytracer/core/ray.hpp"
#include "raytracer/core/ray_state.hpp"

namespace terravox::material {

/// How light fares at a voxel of a material.
enum class Kind : std::uint8_t {
    kSolid,   ///< sends light back from its surface
    kLeaves,  ///< solid, with holes: Texel::opacity
    kWater,   ///< mirrors by Fresnel, lets the rest in
    kGlass,   ///< like water, and clear: ice, glass
};

/// What a material is like throughout. Colours are linear.
struct Look {
    Kind kind = Kind::kSolid;
    voxel::Colour colour;
    float variation = 0;             ///< relative spread of brightness between voxels, [0, 1]
    float roughness = 1;             ///< of its mirror: 0 polished, 1 matt
    float index = 1.5f;              ///< of refraction, [1, 4]
    voxel::Colour absorption_per_m;  ///< of water and glass, >= 0
    voxel::Colour glow;              ///< share of daylight that deep medium gives back, [0, 1]
    voxel::Colour emission;          ///< light of its own, where Texel::emission is 1
    bool reflects = false;  ///< wet or polished all over: mirrors by Fresnel, with its roughness;
                            ///< Texel::gloss says it of parts
    int texture = 0;        ///< number in the list of textures (texture_list.hpp); 0: none
};

/// A place on the face of a voxel.
struct FacePoint {
    core::VoxelCoord voxel;  ///< of `level`
    int level = 0;
    core::Face face = core::Face::kTop;  ///< not kNone
    /// [0, 1) over the face along the axes after the face's own in turn: of an east face u along y
    /// and v along z, of a top face u along z and v along x, of a south face u along x and v along
    /// y. So are the bits of `around`.
    double u = 0, v = 0;
    double footprint = 0;  ///< edge of what a pixel covers here, level-0 voxels
    std::uint8_t around =
        0;  ///< Seen::bits of the face; tells where a roof rises. 0: not known, or nothing there
    double voxel_m = 1;  ///< edge of a level-0 voxel, metres
    bool night = false;  ///< some windows are lit
};

/// What is drawn at such a place. The colour of the surface is `c * ratio * (1 - own_share) + own *
/// own_share`, c being the material's or the orthophoto's.
struct Texel {
    voxel::Colour ratio{
        1, 1, 1};         ///< its mean over a texture, weighted by opacity and 1 - own_share, is 1
    voxel::Colour own;    ///< linear
    float own_share = 0;  ///< [0, 1]
    float opacity = 1;    ///< 0 hole .. 1; between, the share of the pixel's footprint
    float emission = 1;   ///< times Look::emission; of walls: 0, or how brightly a window is lit
    float gloss = 0;      ///< share that mirrors like polished glass, [0, 1]
    std::array<float, 2>
        tilt{};  ///< of water's top: the normal is (tilt[0], 1, tilt[1]), normalised
};

}  // namespace terravox::material
