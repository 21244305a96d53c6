#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "raytracer/core/blocks/block_manager.hpp"
#include "raytracer/core/material/material_table.hpp"
#include "raytracer/core/scene/camera.hpp"
#include "raytracer/core/scene/scene.hpp"
#include "raytracer/core/sky/sky.hpp"
#include "raytracer/core/tiles/square_grid.hpp"
#include "raytracer/core/tiles/tile.hpp"
#include "raytracer/core/walk/level_cut.hpp"
#include "raytracer/core/walk/walk.hpp"

namespace terravox::shade {

class RayEvaluator;
struct View;

/// What the pixels of a view hold instead of light (docs/adr/0029). Immutable.
struct Measuring {
    std::size_t bands = 0;  ///< values of each pixel; 0: they are in its colour
    /// What thin things mean to rays to sun and sky.
    walk::ThinThings thin_things = walk::ThinThings::kBlock;
    /// Called by each thread that traces the view, which outlives the result.
    std::function<std::unique_ptr<const RayEvaluator>(const View&)> make_evaluator;
};

/// Makes what a scene measures; of pictures nullptr.
/// @throws UsageError for a scene that measures what cannot be
using MakeMeasuring = std::shared_ptr<const Measuring> (*)(const scene::Scene& scene,
                                                           const voxel::WorldInfo& world);

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
    std::shared_ptr<const Measuring> measuring = {};  ///< nullptr: a picture

    /// Number of measured values for each pixel; 0 for pictures.
    [[nodiscard]] std::size_t bands() const noexcept { return measuring ? measuring->bands : 0; }
    [[nodiscard]] walk::ThinThings thin_things() const noexcept {
        return measuring ? measuring->thin_things : walk::ThinThings::kBlock;
    }
    [[nodiscard]] tiles::PixelContent content() const noexcept {
        return {wants_layers(), static_cast<std::uint8_t>(bands())};
    }
    [[nodiscard]] bool wants_layers() const noexcept {
        return scene.output.layers != core::PictureLayers::kBeauty || scene.output.denoise;
    }
};

/// The view of a world that a scene describes. A pure function of its arguments on every machine.
/// @param measure nullptr: pictures only
/// @throws UsageError for a level that the world does not have, ...; Error for an empty world
[[nodiscard]] View make_view(const scene::Scene& scene, const voxel::WorldInfo& world,
                             std::shared_ptr<const material::MaterialTable> materials,
                             MakeMeasuring measure = nullptr);

/// The same, with the materials that the scene names.
/// @throws UsageError also for a camera inside rock
[[nodiscard]] View make_view(const scene::Scene& scene, blocks::BlockManager& blocks,
                             MakeMeasuring measure = nullptr);

/// Makes views of one world, one after the other. What a view has in common with the previous one
/// is reused: materials and sky, which take some ten milliseconds.
class ViewMaker {
public:
    explicit ViewMaker(MakeMeasuring measure = nullptr) noexcept : m_measure(measure) {}

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
    MakeMeasuring m_measure;
    std::string m_named;
    std::shared_ptr<const material::MaterialTable> m_materials;  ///< of the material file
    std::optional<std::pair<SkyParameters, sky::Sky>> m_sky;
};

}  // namespace terravox::shade
