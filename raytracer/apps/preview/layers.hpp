#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "raytracer/core/output/picture.hpp"
#include "raytracer/core/shade/view.hpp"

namespace terravox::preview {

/// What the window shows of a picture.
enum class Layer : std::uint8_t {
    kBeauty,
    kDirect,
    kIndirect,
    kDepth,
    kNormal,
    kAlbedo,
    kMaterial,
    kSunlight,
    kSunHours,
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
/// All layers, in the order of the enumeration, in which the window lists them.
inline constexpr std::array<LayerFacts, 14> kLayers{{
    {Layer::kBeauty, "beauty", "the picture"},
    {Layer::kDirect, "direct light", "from sun and sky alone"},
    {Layer::kIndirect, "indirect light", "by way of other surfaces"},
    {Layer::kDepth, "depth",
     "distance, from the world's nearest point, bright, to its farthest; each grey step is a "
     "factor"},
    {Layer::kNormal, "normal", "east red, up green, south blue"},
    {Layer::kAlbedo, "albedo", "share of light that surfaces send back"},
    {Layer::kMaterial, "material", "a colour for each material"},
    {Layer::kSunlight, "sunlight", "share of the sun that is not in shadow"},
    {Layer::kSunHours, "sun hours",
     "hours of direct sun on the day of the scene, from midnight to midnight; finer with each "
     "sample"},
    {Layer::kSquares, "squares", "a colour for each square of a kilometre"},
    {Layer::kOcclusion, "ambient occlusion", "light under an even sky"},
    {Layer::kLevels, "box levels", "level of the boxes that are met: 0 white, then a colour each"},
    {Layer::kSteps, "steps per ray", "cells that a ray visits: blue few, red many"},
    {Layer::kCache, "cache state",
     "boxes in memory in a chequer; orange: not in memory; magenta: a hole"},
}};

[[nodiscard]] constexpr const LayerFacts& collect_facts(Layer layer) noexcept {
    return kLayers[static_cast<std::size_t>(layer)];
}

/// The scene that must be rendered for a layer.
[[nodiscard]] scene::Scene scene_for(Layer layer, scene::Scene scene);
/// Whether a layer shows how rays are walked rather than shading: a ProbeProcessor makes it.
[[nodiscard]] constexpr bool is_probe(Layer layer) noexcept {
    return layer == Layer::kLevels || layer == Layer::kSteps || layer == Layer::kCache;
}

/// Whether a film rendered for this layer holds the scene's picture, too.
[[nodiscard]] constexpr bool has_picture(Layer layer) noexcept {
    return !is_probe(layer) && layer != Layer::kOcclusion && layer != Layer::kSunHours;
}
/// Whether two layers can be shown from the same film, without a new rendering.
[[nodiscard]] bool same_film(Layer a, Layer b) noexcept;
/// A picture for a screen: RGB, 8-bit sRGB, rows from the top.
struct ScreenPicture {
    int width_px = 0;
    int height_px = 0;
    std::vector<std::uint8_t> rgb;

    void resize(int width, int height);
};

/// Shows the pixels of a tile of a film, coarse ones as squares.
/// @param output exposure and tone, which may differ from the view's
/// @param to as large as the film
void show(const output::Film& film, const shade::View& view, const scene::Scene::Output& output,
          Layer layer, const tiles::RenderTile& tile, ScreenPicture& to);

/// The colour that Layer::kMaterial shows a material in.
[[nodiscard]] voxel::Rgb8 colour_of_material(voxel::Material material) noexcept;
/// The colour that Layer::kSunHours shows hours of sun in.
[[nodiscard]] voxel::Colour colour_of_sun_hours(double hours) noexcept;
/// The colour that Layer::kLevels shows a level in.
[[nodiscard]] voxel::Colour colour_of_level(int level) noexcept;

}  // namespace terravox::preview
