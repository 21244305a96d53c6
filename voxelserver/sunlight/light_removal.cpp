#include "voxelserver/sunlight/light_removal.hpp"

#include <optional>

namespace terravox::sunlight {

std::vector<Light> remove_light(const Scene& scene, const FlightLight& light) {
    std::vector<Light> out(scene.size());
    std::optional<SurfaceLight> surface;
    std::optional<ReceivedLight> received;
    if (light.sun) {
        surface = surface_light(scene, *light.sun);
        received.emplace(scene, *surface, light);
    }
    const int border = scene.margin + kEdgeReach;
    for (int z = border; z < scene.height - border; ++z)
        for (int x = border; x < scene.width - border; ++x) {
            const std::size_t i = scene.index(x, z);
            if (scene.shown[i] == 0)
                continue;
            const Light lit = received ? received->at(x, z) : Light{1, 1, 1};
            const Light seen = without_veil(scene.photo[i], light.veil);
            for (std::size_t c = 0; c < 3; ++c)
                out[i][c] = light.gain[c] * seen[c] / lit[c];
        }
    return out;
}

}  // namespace terravox::sunlight
