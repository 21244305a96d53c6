#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "raytracer/output/film.hpp"
#include "raytracer/shade/view.hpp"

namespace terravox::preview {

/// What of a picture is looked at.
enum class Layer : std::uint8_t {
    kBeauty,
    kDirect,
    kIndirect,
    kDepth,
    kNormal,
    kAlbedo,
    kMaterial,
    kSunlight,
    kSquares,
    kOcclusion,
    kLevels,
    kSteps,
    kCache
};

struct LayerFacts {
    Layer layer;
    const char* name;
    const char* doc;
};
/// All of them, in the order of the enumeration, in which they are offered.
inline constexpr std::array<LayerFacts, 13> kLayers{{
    {Layer::kBeauty, "beauty", "the picture"},
    {Layer::kDirect, "direct light", "from sun and sky alone"},
    {Layer::kIndirect, "indirect light", "by way of other things"},
    {Layer::kDepth, "depth",
     "distance, from the world's nearest point, bright, to its farthest; each grey step is a "
     "factor"},
    {Layer::kNormal, "normal", "east red, up green, south blue"},
    {Layer::kAlbedo, "albedo", "share of light that surfaces send back"},
    {Layer::kMaterial, "material", "a colour for each material"},
    {Layer::kSunlight, "sunlight", "share of the sun that is not in shadow"},
    {Layer::kSquares, "squares", "a colour for each square of a kilometre"},
    {Layer::kOcclusion, "ambient occlusion", "light under an even sky"},
    {Layer::kLevels, "box levels", "level of the boxes that are met: 0 white, then a colour each"},
    {Layer::kSteps, "steps per ray", "cells that a ray visits: blue few, red many"},
    {Layer::kCache, "cache state",
     "boxes in memory in a chequer; orange: not in memory; magenta: a hole"},
}};

[[nodiscard]] constexpr const LayerFacts& facts_of(Layer layer) noexcept {
    return kLayers[static_cast<std::size_t>(layer)];
}

/// What has to be rendered for a layer, instead of the picture of the scene.
[[nodiscard]] scene::Scene scene_for(Layer layer, scene::Scene scene);
/// Layers that come from walking rays rather than from shading: a ProbeProcessor makes them.
[[nodiscard]] constexpr bool is_probe(Layer layer) noexcept {
    return layer == Layer::kLevels || layer == Layer::kSteps || layer == Layer::kCache;
}

/// Whether a film for this layer is one of the scene's picture, too.
[[nodiscard]] constexpr bool has_picture(Layer layer) noexcept {
    return !is_probe(layer) && layer != Layer::kOcclusion;
}
/// Whether two layers can be shown of the same film: no new picture is needed.
[[nodiscard]] bool same_film(Layer a, Layer b) noexcept;
/// Bytes as a screen shows them: RGB, 8-bit sRGB, rows from the top.
struct ScreenPicture {
    int width_px = 0, height_px = 0;
    std::vector<std::uint8_t> rgb;

    void resize(int width, int height);
};

/// Shows the pixels of a tile of a film, coarse ones as squares.
/// @param output exposure and tone; the view may be of others @param to as large as the film
void show(const output::Film& film, const shade::View& view, const scene::Scene::Output& output,
          Layer layer, const tiles::RenderTile& tile, ScreenPicture& to);

/// The colour that Layer::kMaterial shows a material in.
[[nodiscard]] voxel::Rgb8 colour_of_material(voxel::Material material) noexcept;
/// The colour that Layer::kLevels shows a level in.
[[nodiscard]] voxel::Colour colour_of_level(int level) noexcept;

}  // namespace terravox::preview
