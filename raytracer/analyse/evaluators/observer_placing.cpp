#include "raytracer/analyse/evaluators/observer_placing.hpp"

#include <array>
#include <cstdio>
#include <optional>

#include "common/util/error.hpp"
#include "raytracer/analyse/evaluators/column_descent.hpp"
#include "raytracer/analyse/evaluators/sight_line.hpp"
#include "raytracer/core/scene/camera.hpp"
#include "raytracer/core/walk/walker.hpp"

namespace terravox::analyse {
namespace {

std::string number(double v) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.10g", v);
    return text.data();
}

/// Places the observers of one analysis.
class Placing {
public:
    Placing(const voxel::WorldInfo& world, const walk::LevelCut& cut, blocks::BlockManager& blocks)
        : m_world(world), m_blocks(blocks), m_reader(blocks), m_walker(m_reader, cut) {}

    [[nodiscard]] std::array<double, 3> place(const Observer& observer) {
        check_area(observer);
        const double y = observer.height_m / m_world.voxel_m + base_of(observer);
        const core::Vec3 at = on_sight_grid({observer.x, y, observer.z});
        check_free(observer, at);
        return {at.x, at.y, at.z};
    }

private:
    [[noreturn]] static void refuse(const Observer& observer, const std::string& why) {
        throw util::UsageError("place the observer " + observer.text + ": " + why);
    }

    void check_area(const Observer& observer) const {
        const voxel::VoxelBounds& b = m_world.bounds;
        if (observer.x >= b.min[0] && observer.x < b.max[0] && observer.z >= b.min[2] &&
            observer.z < b.max[2])
            return;
        const bool is_placed = !m_world.crs.empty();
        const double unit = is_placed ? m_world.crs_units_per_voxel : 1;
        const double low = is_placed ? -b.max[2] * unit : b.min[2];
        const double high = is_placed ? -b.min[2] * unit : b.max[2];
        refuse(observer, std::string("it lies outside of the data; allowed: ") +
                             (is_placed ? "E " : "x ") + number(b.min[0] * unit) + " to " +
                             number(b.max[0] * unit) + (is_placed ? ", N " : ", z ") + number(low) +
                             " to " + number(high));
    }

    /// The first voxel that a vertical ray meets.
    [[nodiscard]] std::optional<walk::Hit> met(const Observer& observer,
                                               const std::optional<walk::Hit>& hit) const {
        if (hit && hit->hole) {
            m_blocks.check_world();
            throw util::Error("place the observer " + observer.text +
                              ": the data there cannot be read");
        }
        return hit;
    }

    /// Height that the observer's counts from, level-0 voxels.
    [[nodiscard]] double base_of(const Observer& observer) {
        if (observer.base == HeightBase::kZero)
            return 0;
        const auto surface = observer.base == HeightBase::kTop ? core::AnalysisSurface::kTop
                                                               : core::AnalysisSurface::kGround;
        walk::TracedRay ray = cell_ray(above(observer), 0);
        std::optional<walk::Hit> hit = met(observer, m_walker.first_hit(ray.ray));
        if (!hit)
            refuse(observer,
                   "there are no data at that place; allowed: a height of its own, E,N,H");
        const double top = top_of(*hit) * m_world.voxel_m;
        while (hit) {
            ray.end = walk::WalkEnd::kHit;
            ray.hit = *hit;
            const CellStep step = cell_step_at(ray, surface);
            if (step == CellStep::kMeasure)
                return top_of(*hit);
            if (step == CellStep::kNothing)
                break;
            ray = below(ray);
            hit = met(observer,
                      m_walker.first_hit_from(
                          ray.ray, {ray.state.voxel[0], ray.state.voxel[1], ray.state.voxel[2]},
                          ray.state.level));
        }
        refuse(observer, "the ground there is not known, inside of what is " + number(top) +
                             " m high; allowed: E,N,+ABOVE on its top");
    }

    void check_free(const Observer& observer, core::Vec3 at) {
        if (at.y >= m_world.bounds.max[1])
            return;
        const std::optional<walk::Hit> hit = m_walker.first_hit({at, {0, -1, 0}});
        if (hit && hit->face != core::Face::kNone)
            return;
        (void)met(observer, hit);
        const walk::TracedRay down = cell_ray(above(observer), 0);
        const std::optional<walk::Hit> top = met(observer, m_walker.first_hit(down.ray));
        // Where there is nothing at all, there is nothing to be inside of.
        if (!top)
            return;
        refuse(observer, "at " + number(at.y * m_world.voxel_m) + " m it lies " +
                             (hit ? "inside of something solid" : "below the ground") +
                             "; allowed: " + number(top_of(*top) * m_world.voxel_m) +
                             " m and more, the top there");
    }

    /// A ray that starts above everything.
    [[nodiscard]] core::Ray above(const Observer& observer) const noexcept {
        return {{observer.x, static_cast<double>(m_world.bounds.max[1]) + 1, observer.z}, {}};
    }

    const voxel::WorldInfo& m_world;
    blocks::BlockManager& m_blocks;
    walk::BlockReader m_reader;
    walk::Walker m_walker;
};

}  // namespace

scene::PointList place_observers(std::span<const Observer> observers, const scene::Scene& scene,
                                 blocks::BlockManager& blocks) {
    const voxel::WorldInfo& world = blocks.world_info();
    const scene::Camera camera = scene::make_camera(scene, world, world.camera_bounds());
    const walk::LevelCut cut(world.bounds, camera, scene.quality.detail, scene.quality.level,
                             world.levels - 1);
    Placing placing(world, cut, blocks);
    scene::PointList out;
    for (const Observer& observer : observers)
        out.points.push_back(placing.place(observer));
    return out;
}

}  // namespace terravox::analyse
