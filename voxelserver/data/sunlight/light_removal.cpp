#include "voxelserver/data/sunlight/light_removal.hpp"

#include <optional>

namespace terravox::sunlight {

std::vector<Light> remove_light(const Surface& surface, const Scene& inner,
                                const LightField& light) {
    std::vector<Light> out(inner.size());
    std::optional<SurfaceLight> lit;
    std::optional<ReceivedLight> received;
    if (light.middle.sun) {
        lit = surface_light(surface, *light.middle.sun);
        received.emplace(inner, *lit, light.middle);
    }
    const auto along = [&](int at, int side) {
        return (static_cast<float>(at - kEdgeReach) + 0.5F) /
               static_cast<float>(side - 2 * kEdgeReach);
    };
    for (int z = kEdgeReach; z < inner.height - kEdgeReach; ++z)
        for (int x = kEdgeReach; x < inner.width - kEdgeReach; ++x) {
            const std::size_t i = inner.index(x, z);
            if (inner.shown[i] == 0)
                continue;
            const LightField::Levels levels =
                light.at(along(x, inner.width), along(z, inner.height));
            const Light seen = without_veil(inner.photo[i], levels.veil);
            const float sun = received ? received->sun_at(x, z) : 1;
            const float sky_seen = received ? lit->sky_seen[i] : 1;
            for (std::size_t c = 0; c < 3; ++c) {
                const float light_there = levels.sky[c] * sky_seen + (1 - levels.sky[c]) * sun;
                out[i][c] = levels.gain[c] * seen[c] / light_there;
            }
        }
    return out;
}

}  // namespace terravox::sunlight
