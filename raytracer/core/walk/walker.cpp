#include "raytracer/core/walk/walker.hpp"

namespace terravox::walk {

std::optional<Hit> Walker::first_hit(const core::Ray& ray, StopAt stop, double t_max) {
    ++m_rays;
    core::RayState state(ray);
    if (!state.enter(m_walk.cut().entry_bounds()))
        return std::nullopt;
    return finish(state, stop, t_max);
}

std::optional<Hit> Walker::first_hit_from(const core::Ray& ray, core::VoxelCoord start,
                                          int its_level, StopAt stop, double t_max) {
    ++m_rays;
    core::RayState state(ray);
    state.start_in(start, its_level);
    return finish(state, stop, t_max);
}

std::optional<Hit> Walker::finish(core::RayState& ray, StopAt stop, double t_max) {
    Hit hit;
    while (true) {
        const WalkEnd end = m_walk.first_hit(ray, stop, t_max, hit);
        if (end == WalkEnd::kHit)
            return hit;
        if (end == WalkEnd::kMiss)
            return std::nullopt;
        (void)m_walk.reader().blocks().get(m_walk.missing());
    }
}

}  // namespace terravox::walk
