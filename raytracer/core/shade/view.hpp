#pragma once

#include <memory>

#include "raytracer/analyse/solar/energy.hpp"
#include "raytracer/analyse/solar/far_horizon.hpp"
#include "raytracer/analyse/solar/sun_way.hpp"
#include "raytracer/core/base/analysis_bands.hpp"
#include "raytracer/core/material/material_table.hpp"
#include "raytracer/core/scene/camera.hpp"
#include "raytracer/core/scene/scene.hpp"
#include "raytracer/core/sky/sky.hpp"
#include "raytracer/core/tiles/square_grid.hpp"
#include "raytracer/core/tiles/tile.hpp"
#include "raytracer/core/walk/level_cut.hpp"

namespace terravox::shade {

/// Everything that all rays of a picture have in common. Immutable and shared by all processors.
struct View {
    scene::Scene scene;
    scene::Camera camera;
    sky::Sky sky;
    std::shared_ptr<const material::MaterialTable> materials;
    walk::LevelCut cut;  ///< which boxes are used
    double voxel_m = 1;  ///< edge of a level-0 voxel
    tiles::SquareGrid squares;
    core::Vec3 origin;       ///< of the positions in the picture's layers: Camera::picture_origin
    bool night = false;      ///< windows are lit
    bool lamps = false;      ///< lamps are sampled; else their light is met by chance
    double exposure_ev = 0;  ///< of 8-bit pictures, including the adaptation to the daylight
    float max_indirect = 0;  ///< greatest light of one indirect sample; 0: no limit
    solar::Energy energy = {};       ///< of an analysis of energy
    solar::SunWay sun_way = {};      ///< of an analysis of the sun
    solar::FarHorizon horizon = {};  ///< of an analysis: terrain outside of the data

    /// Number of measured values for each pixel; 0 for pictures.
    [[nodiscard]] std::size_t bands() const noexcept {
        return core::band_count(scene.analysis.kind);
    }
    [[nodiscard]] tiles::PixelContent content() const noexcept {
        return {wants_layers(), static_cast<std::uint8_t>(bands())};
    }
    [[nodiscard]] bool wants_layers() const noexcept {
        return scene.output.layers != core::PictureLayers::kBeauty || scene.output.denoise;
    }
};

}  // namespace terravox::shade
