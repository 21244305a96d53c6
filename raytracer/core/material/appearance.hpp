#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "common/voxel/colour.hpp"
#include "raytracer/core/base/ray.hpp"
#include "raytracer/core/base/ray_state.hpp"

namespace terravox::material {

/// How light interacts with a voxel of a material.
enum class Kind : std::uint8_t {
    kSolid,   ///< reflects light from its surface
    kLeaves,  ///< solid, with holes: Texel::opacity
    kWater,   ///< reflects by Fresnel and transmits the rest
    kGlass,   ///< like water, and clear: ice, glass
};

/// Properties of a material that are the same everywhere. Colours are linear.
struct MaterialAppearance {
    Kind kind = Kind::kSolid;
    voxel::Colour colour;
    float variation = 0;             ///< relative spread of brightness between voxels, [0, 1]
    float roughness = 1;             ///< of its specular reflection: 0 polished, 1 matt
    float index = 1.5f;              ///< of refraction, [1, 4]
    voxel::Colour absorption_per_m;  ///< of water and glass, >= 0
    voxel::Colour glow;              ///< share of daylight that a deep medium sends back, [0, 1]
    voxel::Colour emission;          ///< light of its own, where Texel::emission is 1
    /// Wet or polished all over: reflects by Fresnel, with its roughness; Texel::gloss does this
    /// for parts of a face.
    bool reflects = false;
    int texture = 0;  ///< number in the list of textures (texture_list.hpp); 0: none
};

/// A point on the face of a voxel.
struct FacePoint {
    core::VoxelCoord voxel;  ///< of `level`
    int level = 0;
    core::Face face = core::Face::kTop;  ///< not kNone
    /// [0, 1) over the face along the axes after the face's own in cyclic order: of an east face u
    /// along y and v along z, of a top face u along z and v along x, of a south face u along x and
    /// v along y. The bits of `around` use the same axes.
    double u = 0;
    double v = 0;
    double footprint = 0;  ///< edge of what a pixel covers here, level-0 voxels
    /// Seen::bits of the face, which give the slope of a roof. 0: not known, or nothing there.
    std::uint8_t around = 0;
    double voxel_m = 1;  ///< edge of a level-0 voxel, metres
    bool night = false;  ///< some windows are lit
};

/// The texture at such a point. The colour of the surface is `c * ratio * (1 - own_share) + own *
/// own_share`, where c is the colour of the material or of the orthophoto.
struct Texel {
    /// The mean over a texture, weighted by opacity and 1 - own_share, is 1.
    voxel::Colour ratio{1, 1, 1};
    voxel::Colour own;    ///< linear
    float own_share = 0;  ///< [0, 1]
    /// 0: hole, 1: solid; between: share of the pixel's footprint that is covered.
    float opacity = 1;
    float emission = 1;  ///< factor of MaterialAppearance::emission; of walls: 0, or how brightly a
                         ///< window is lit
    float gloss = 0;     ///< share that reflects like polished glass, [0, 1]
    /// Of water's top: the normal is (tilt[0], 1, tilt[1]), normalised.
    std::array<float, 2> tilt{};
};

using MaterialAppearances = std::array<MaterialAppearance, voxel::kMaterialCount>;

/// The contents of a material file.
struct MaterialFile {
    MaterialAppearances appearances;
    /// Materials that the file does not name, without a table `default` that stands for them: they
    /// get the plain colour of `unknown`.
    std::vector<std::string> missing;
};

/// @param name empty: config/materials.toml; NAME: config/materials-NAME.toml; or a path, which
/// ends in .toml
/// @throws UsageError naming the files that exist
[[nodiscard]] std::filesystem::path find_materials(const std::string& name);

/// @throws UsageError naming file, material, field, value and allowed range; also for unknown
/// materials and fields
[[nodiscard]] MaterialFile read_materials(const std::filesystem::path& file);

/// The same for a text.
/// @param name used in messages
[[nodiscard]] MaterialFile parse_materials(const std::string& text, const std::string& name);

}  // namespace terravox::material
