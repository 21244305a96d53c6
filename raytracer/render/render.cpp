#include "raytracer/render/render.hpp"

#include <spdlog/spdlog.h>

#include <cmath>

#include "common/util/config_dir.hpp"
#include "common/util/error.hpp"
#include "common/util/version.hpp"
#include "raytracer/output/progress.hpp"
#include "raytracer/tiles/tile_plan.hpp"
#include "raytracer/world/block_manager.hpp"

namespace terravox {
namespace {

void check_camera(const View& view, BlockManager& blocks) {
    if (view.scene.camera.inside_rock) return;
    BlockReader reader(blocks, view.scene.quality.level);
    const Vec3 p = view.camera.position() * (1.0 / (1 << view.scene.quality.level));
    for (const double c : {p.x, p.y, p.z})
        if (!(std::abs(c) < 1.0e9)) throw UsageError("place the camera: its position lies beyond 10^9 voxels");
    const VoxelCoord at{static_cast<std::int32_t>(std::floor(p.x)), static_cast<std::int32_t>(std::floor(p.y)), static_cast<std::int32_t>(std::floor(p.z))};
    for (int a = 0; a < 3; ++a)
        if (at[a] < view.bounds.min[static_cast<std::size_t>(a)] || at[a] >= view.bounds.max[static_cast<std::size_t>(a)]) return;
    if (!reader.solid(at.x, at.y, at.z)) return;
    std::int32_t free_y = at.y;
    while (free_y < view.bounds.max[1] && reader.solid(at.x, free_y, at.z)) ++free_y;
    throw UsageError("place the camera: voxel (" + std::to_string(at.x) + ", " + std::to_string(at.y) + ", " + std::to_string(at.z) +
                     ") is solid; allowed: " + std::to_string(static_cast<int>(std::ceil((free_y - at.y) * view.voxel_m * (1 << view.scene.quality.level)))) +
                     " m higher, or --camera-inside-rock yes");
}

}  // namespace

View make_view(const Scene& scene, BlockManager& blocks) {
    const voxel::WorldInfo& world = blocks.world_info();
    const int level = scene.quality.level;
    if (level >= world.levels) throw UsageError("choose the level: quality.level = " + std::to_string(level) + "; this world has 0 to " + std::to_string(world.levels - 1));
    if (world.bounds.empty()) throw Error("render the world '" + world.title + "': it is empty");
    voxel::VoxelBounds bounds = world.bounds;
    for (std::size_t a = 0; a < 3; ++a) {
        bounds.min[a] = voxel::floor_div(bounds.min[a], 1 << level);
        bounds.max[a] = voxel::floor_div(bounds.max[a] - 1, 1 << level) + 1;
    }
    View view{scene, make_camera(scene, world, world.bounds), Sky(sun_of(scene.sun, world.centre ? &*world.centre : nullptr), scene.sun, scene.sky),
              voxel::load_palette(util::config_dir() / "materials.toml"), bounds, world.voxel_m};
    check_camera(view, blocks);
    return view;
}

RenderCounts render_film(const RenderJob& job, Film& film) {
    const auto& q = job.view.scene.quality;
    const auto passes = plan_tiles(film.width_px(), film.height_px(), q.coarse_step, q.tile_px, q.tile_order);
    RenderCounts counts;
    Progress progress(passes.size() * passes.front().size(), static_cast<std::uint64_t>(film.width_px()) * static_cast<std::uint64_t>(film.height_px()), job.quiet);
    for (const auto& tiles : passes) {
        std::size_t submitted = 0, done = 0;
        while (done < tiles.size()) {
            if (job.stop != nullptr && *job.stop) {
                job.processor.cancel();
                throw Error("render: interrupted; no picture was written");
            }
            while (submitted < tiles.size() && submitted - done < static_cast<std::size_t>(job.tiles_in_flight)) job.processor.submit(tiles[submitted++]);
            const auto result = job.processor.take();
            if (!result) throw Error("render: the processor ended before the picture was finished");
            film.add(*result);
            ++done, ++counts.tiles;
            counts.rays += result->rays, counts.steps += result->steps, counts.hole_rays += result->hole_rays;
            progress.tile_done(result->samples.size(), result->rays);
        }
    }
    progress.finish();
    return counts;
}

ImageMetadata metadata_of(const View& view, const voxel::WorldInfo& world, std::size_t holes) {
    const Vec3 p = view.camera.position();
    const auto text = [](double v) { return std::to_string(v); };
    ImageMetadata out = {{"Software", std::string("terravox ") + kVersion}, {"ImageDescription", world.title}, {"terravox:voxel_m", text(world.voxel_m)},
                         {"terravox:camera", text(p.x) + " " + text(p.y) + " " + text(p.z)}, {"terravox:holes", std::to_string(holes)}};
    if (!world.crs.empty()) out.emplace_back("terravox:crs", world.crs);
    if (!world.attribution.empty()) out.emplace_back("Copyright", world.attribution);
    return out;
}

}  // namespace terravox
