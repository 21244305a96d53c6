#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "raytracer/core/blocks/block_manager.hpp"
#include "raytracer/core/shade/view.hpp"

namespace terravox::shade {

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
