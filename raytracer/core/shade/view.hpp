#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "raytracer/analyse/solar/energy.hpp"
#include "raytracer/analyse/solar/far_horizon.hpp"
#include "raytracer/analyse/solar/sun_way.hpp"
#include "raytracer/core/base/analysis_bands.hpp"
#include "raytracer/core/blocks/block_manager.hpp"
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

/// The view of a world that a scene describes. A pure function of its arguments on every machine.
/// @throws UsageError for a level that the world does not have, ...; Error for an empty world
[[nodiscard]] View make_view(const scene::Scene& scene, const voxel::WorldInfo& world,
                             std::shared_ptr<const material::MaterialTable> materials);

/// The same, with the materials that the scene names.
/// @throws UsageError also for a camera inside rock
[[nodiscard]] View make_view(const scene::Scene& scene, blocks::BlockManager& blocks);

/// Makes views of one world, one after the other. What a view has in common with the previous one
/// is reused: materials and sky, which take some ten milliseconds.
class ViewMaker {
public:
    /// @throws as make_view
    [[nodiscard]] View make(const scene::Scene& scene, blocks::BlockManager& blocks);

    /// Everything that a sky depends on.
    struct SkyParameters {
        geo::SunPosition sun;
        scene::Scene::Sun sun_settings;
        scene::Scene::Sky sky_settings;
        double place_height_m = 0;
        core::Vec3 eye_m;  ///< ignored without clouds
        friend bool operator==(const SkyParameters&, const SkyParameters&) = default;
    };

private:
    std::string m_named;
    std::shared_ptr<const material::MaterialTable> m_materials;  ///< of the material file
    std::optional<std::pair<SkyParameters, sky::Sky>> m_sky;
};

}  // namespace terravox::shade
