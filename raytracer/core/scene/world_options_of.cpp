#include "raytracer/core/scene/world_options_of.hpp"

namespace terravox::scene {

worlds::WorldOptions world_options_of(const Scene& scene) {
    worlds::WorldOptions out;
    out.crs = scene.world.crs;
    out.classes = scene.world.classes;
    out.vertical_unit = scene.world.vertical_unit;
    out.settings = scene.world.settings;
    out.steps = scene.world.steps;
    out.photo = scene.world.photo;
    out.voxel_m = scene.world.voxel_m;
    out.dimension = scene.world.dimension;
    out.base_m = scene.world.base_m;
    out.generated = scene.generated;
    out.memory_bytes = static_cast<std::size_t>(scene.world.memory_mib) << 20;
    out.threads = scene.processing.threads.value_or(0);
    out.box_timeout = std::chrono::seconds(scene.processing.box_timeout_s);
    return out;
}

}  // namespace terravox::scene
