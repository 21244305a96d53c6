#include "tests/bench/paper/box_sizes.hpp"

#include <optional>

#include "common/util/error.hpp"
#include "raytracer/blocks/block_manager.hpp"
#include "raytracer/shade/view_maker.hpp"
#include "raytracer/walk/surroundings.hpp"
#include "raytracer/walk/walker.hpp"
#include "tests/bench/bench.hpp"
#include "tests/bench/paper/cube_trees.hpp"

namespace terravox::bench {
namespace {

constexpr std::size_t kBoxMemory_bytes = std::size_t{2} << 30;

/// Where the ray of a pixel ends.
struct Seen {
    bool hit = false;
    bool shadowed = false;  ///< the ray to the sun from there meets something
    double t = 0;
    core::VoxelCoord voxel;
    friend bool operator==(const Seen&, const Seen&) = default;
};

/// From what a ray has met to the sun.
core::RayState sun_ray(const core::Ray& primary, double t, core::VoxelCoord voxel, core::Face face,
                       const core::Vec3& to_sun) {
    core::RayState out(core::Ray{primary.origin + primary.direction * t, to_sun});
    out.start_in(walk::neighbour(voxel, face), 0);
    return out;
}

template <int kLevels>
Seen seen_by(CubeTrees<kLevels>& trees, const core::Ray& primary, const shade::View& view,
             const core::Vec3& to_sun) {
    core::RayState ray(primary);
    if (!ray.enter(view.cut.entry_bounds()) || !trees.first_hit(ray))
        return {};
    Seen out{true, false, ray.t, {ray.voxel[0], ray.voxel[1], ray.voxel[2]}};
    if (ray.face != core::Face::kNone) {
        core::RayState towards = sun_ray(primary, out.t, out.voxel, ray.face, to_sun);
        out.shadowed = trees.first_hit(towards);
    }
    return out;
}

/// By the program's walk of single rays.
Seen seen_by(walk::Walker& walker, const core::Ray& primary, const core::Vec3& to_sun) {
    const std::optional<walk::Hit> hit = walker.first_hit(primary);
    if (!hit)
        return {};
    Seen out{true, false, hit->t, hit->voxel};
    if (hit->face != core::Face::kNone)
        out.shadowed = walker
                           .first_hit_from({primary.origin + primary.direction * hit->t, to_sun},
                                           walk::neighbour(hit->voxel, hit->face))
                           .has_value();
    return out;
}

/// Row by row.
template <class SeenAt>
std::vector<Seen> picture(const shade::View& view, const SeenAt& seen_at) {
    const auto [width, height] = view.scene.output.size_px;
    std::vector<Seen> out;
    out.reserve(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            out.push_back(seen_at(view.camera.ray(x + 0.5, y + 0.5)));
    return out;
}

template <int kLevels>
BoxSize measure(const std::vector<Brick>& bricks, const shade::View& view,
                const voxel::VoxelBounds& bounds, const std::vector<Seen>& wanted, int rounds) {
    const core::Vec3 to_sun = view.sky.to_sun();
    BoxSize out;
    out.edge_voxels = CubeTrees<kLevels>::kEdge;
    for (int round = 0; round < rounds; ++round) {
        std::optional<CubeTrees<kLevels>> trees;
        out.make_s.push_back(seconds_of([&] { trees.emplace(bricks, bounds); }));
        std::vector<Seen> seen;
        out.walk_s.push_back(seconds_of([&] {
            seen = picture(view, [&](const core::Ray& primary) {
                return seen_by(*trees, primary, view, to_sun);
            });
        }));
        std::size_t rays = 0;
        for (std::size_t i = 0; i < seen.size(); ++i) {
            if (!(seen[i] == wanted[i]))
                throw util::Error("walk boxes of " + std::to_string(out.edge_voxels) +
                                  " voxels: pixel " + std::to_string(i) +
                                  " sees something else than with the program's boxes");
            rays += seen[i].hit ? 2 : 1;
        }
        out.boxes = trees->cubes();
        out.tree_bytes = static_cast<double>(trees->tree_bytes());
        out.steps = static_cast<double>(trees->steps()) / static_cast<double>(rays);
    }
    return out;
}

}  // namespace

std::vector<BoxSize> measure_box_sizes(voxel::World& world, const scene::Scene& given, int rounds) {
    scene::Scene scene = given;
    scene.quality.detail = 0;  // level 0 everywhere
    blocks::BlockManager blocks(world, kBoxMemory_bytes);
    const shade::View view = shade::make_view(scene, blocks);
    const core::Vec3 to_sun = view.sky.to_sun();
    walk::BlockReader reader(blocks);
    walk::Walker walker(reader, view.cut);
    const std::vector<Seen> wanted =
        picture(view, [&](const core::Ray& primary) { return seen_by(walker, primary, to_sun); });
    const std::vector<Brick> bricks = bricks_of(world);
    const voxel::VoxelBounds& bounds = view.cut.bounds(0);
    return {measure<2>(bricks, view, bounds, wanted, rounds),
            measure<3>(bricks, view, bounds, wanted, rounds),
            measure<4>(bricks, view, bounds, wanted, rounds)};
}

}  // namespace terravox::bench
