#include "voxelserver/sunlight/light_removal.hpp"

#include <optional>

namespace terravox::sunlight {

std::vector<Light> remove_light(const Scene& scene, const LightField& light) {
    std::vector<Light> out(scene.size());
    std::optional<Scene> inner;
    std::optional<SurfaceLight> surface;
    std::optional<ReceivedLight> received;
    if (light.middle.sun) {
        inner = inner_cells(scene);
        surface = surface_light(scene, *light.middle.sun);
        received.emplace(*inner, *surface, light.middle);
    }
    const int border = scene.margin + kEdgeReach;
    const auto along = [&](int at, int side) {
        return (static_cast<float>(at - border) + 0.5F) / static_cast<float>(side - 2 * border);
    };
    for (int z = border; z < scene.height - border; ++z)
        for (int x = border; x < scene.width - border; ++x) {
            const std::size_t i = scene.index(x, z);
            if (scene.shown[i] == 0)
                continue;
            const LightField::Levels levels =
                light.at(along(x, scene.width), along(z, scene.height));
            const Light seen = without_veil(scene.photo[i], levels.veil);
            const int inner_x = x - scene.margin;
            const int inner_z = z - scene.margin;
            const float sun = received ? received->sun_at(inner_x, inner_z) : 1;
            const float sky_seen = received ? surface->sky_seen[inner->index(inner_x, inner_z)] : 1;
            for (std::size_t c = 0; c < 3; ++c) {
                const float lit = levels.sky[c] * sky_seen + (1 - levels.sky[c]) * sun;
                out[i][c] = levels.gain[c] * seen[c] / lit;
            }
        }
    return out;
}

}  // namespace terravox::sunlight
