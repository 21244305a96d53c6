#include "raytracer/core/shade/shading.hpp"

#include "raytracer/core/walk/walk.hpp"
#include "tests/catch.hpp"
#include "tests/raytracer/landscape.hpp"

using namespace terravox;
using terravox::test::Job;
using terravox::test::small_scene;
using voxel::Material;

namespace {

/// A ray from (0.3, 10.4, 0.6) that has met a face of the voxel (0, 4, 0), or a voxel around its
/// own start.
walk::TracedRay met(const shade::Shading& shading, Material material, core::Face face,
                    core::Vec3 direction = core::normalized({0.02, -1, 0.03})) {
    walk::TracedRay ray = shading.primary({{0.3, 10.4, 0.6}, direction}, 0);
    ray.footprint = 0.01f;
    ray.spread = 0;
    ray.end = walk::WalkEnd::kHit;
    ray.hit.face = face;
    ray.hit.attr.material = material;
    ray.hit.t = face == core::Face::kNone ? 0 : -5.4 / direction.y;
    ray.hit.voxel =
        face == core::Face::kNone ? core::VoxelCoord{0, 10, 0} : core::VoxelCoord{0, 4, 0};
    return ray;
}

struct Shaded {
    shade::SampleSum sum;
    std::vector<walk::TracedRay> next;
};
Shaded shade_rays(const shade::Shading& shading, const walk::TracedRay& ray,
                  std::uint32_t sample = 0) {
    Shaded out;
    out.sum.numbers = shade::Sampler(3, 7, sample);
    shading.shade(ray, out.sum, out.next);
    return out;
}

}  // namespace

TEST_CASE("an occlusion ray leaves the foliage that it starts in, and nothing else",
          "[raytracer][shade]") {
    const Job job(small_scene());
    const auto shading = shade::make_shading(job.view);
    for (const walk::RayKind kind :
         {walk::RayKind::kShadow, walk::RayKind::kSky, walk::RayKind::kAmbient}) {
        INFO(walk::to_name(kind));
        for (const Material material : {Material::kHighVegetation, Material::kRock}) {
            walk::TracedRay ray = met(*shading, material, core::Face::kNone);
            ray.kind = kind;
            ray.leaves = true;
            const Shaded out = shade_rays(*shading, ray);
            CHECK(voxel::luminance(out.sum.direct) == 0);
            REQUIRE(out.next.size() == (material == Material::kHighVegetation ? 1 : 0));
            if (out.next.empty())
                continue;
            CHECK(out.next[0].end == walk::WalkEnd::kWaits);
            CHECK(out.next[0].state.voxel[1] == 9);
        }
    }
}

TEST_CASE("a mixed colour is not that of an object next to the voxel", "[raytracer][shade]") {
    const voxel::Rgb8 lake{40, 110, 125};
    const voxel::Rgb8 meadow{90, 120, 60};
    const voxel::Rgb8 shade{45, 55, 58};
    const voxel::Rgb8 roof{170, 80, 60};
    struct Case {
        const char* name;
        Material material;
        voxel::Rgb8 photo;
        core::VoxelColour colour;
        float least, most;  ///< share of the photo in what is shown
    };
    Job job(small_scene());
    for (const Case& c :
         {Case{"a meadow", Material::kGrass, meadow, core::VoxelColour::kMix, 0.84f, 0.86f},
          Case{"a shore that shows the lake", Material::kGrass, lake, core::VoxelColour::kMix, 0,
               0.001f},
          Case{"leaves over the lake", Material::kHighVegetation, lake, core::VoxelColour::kMix, 0,
               0.001f},
          Case{"leaves in the shade", Material::kHighVegetation, shade, core::VoxelColour::kMix,
               0.5f, 0.86f},
          Case{"the lake itself", Material::kConcrete, lake, core::VoxelColour::kMix, 0.84f, 0.86f},
          Case{"a wall that shows the roof", Material::kWall, roof, core::VoxelColour::kMix, 0,
               0.001f},
          Case{"a wall, as the photo has it", Material::kWall, roof, core::VoxelColour::kTrue,
               0.999f, 1.001f},
          Case{"a shore, as the photo has it", Material::kGrass, lake, core::VoxelColour::kTrue,
               0.999f, 1.001f}}) {
        INFO(c.name);
        scene::Scene scene = small_scene();
        scene.quality.colour = c.colour;
        scene.quality.textures = false;
        const shade::View view = shade::make_view(scene, job.blocks);
        const auto shading = shade::make_shading(view);
        walk::TracedRay ray = met(*shading, c.material, core::Face::kTop);
        const voxel::Colour plain = shade::surface_at(view, ray).albedo;
        ray.hit.attr.colour = c.photo;
        ray.hit.attr.flags = voxel::VoxelAttr::kHasColour;
        const voxel::Colour shown = shade::surface_at(view, ray).albedo;
        scene.quality.colour = core::VoxelColour::kTrue;
        const shade::View photo_view = shade::make_view(scene, job.blocks);
        const voxel::Colour photo = shade::surface_at(photo_view, ray).albedo;
        const float share = (shown.g - plain.g) / (photo.g - plain.g);
        CHECK(share >= c.least);
        CHECK(share <= c.most);
    }
}

TEST_CASE("faces between leaves get light from every kind of occlusion ray", "[raytracer][shade]") {
    struct Kind {
        const char* name;
        void (*set)(scene::Scene&);
    };
    const Kind kinds[] = {
        {"sun", [](scene::Scene& s) { s.sky.strength = 0; }},
        {"ambient occlusion",
         [](scene::Scene& s) {
             s.quality.ao_rays = 4;
             s.sun.strength = 0;
         }},
        {"paths",
         [](scene::Scene& s) {
             s.quality.integrator = core::Integrator::kPath;
             s.sun.strength = 0;
         }},
    };
    for (const Kind& kind : kinds) {
        scene::Scene scene = small_scene();
        scene.output.size_px = {64, 64};
        scene.quality.samples = 1;
        scene.quality.bounces = 0;
        scene.sun.altitude_deg = 70;
        scene.camera.space = core::CoordinateSpace::kVoxel;
        scene.camera.position = {{0.5, 5, 0.5}};
        scene.camera.target = {{0.6, 0, 0.6}};
        kind.set(scene);
        auto world = std::make_unique<test::ArrayWorld>(test::ArrayWorld::Coord{-20, -4, -20},
                                                        test::ArrayWorld::Coord{20, 8, 20});
        world->fill({-20, -4, -20}, {20, 0, 20}, Material::kSand);
        world->fill({-20, 0, -20}, {20, 1, 20}, Material::kLowVegetation);
        world->editable_info().bounds = world->level_bounds();
        Job job(scene, std::size_t{64} << 20, std::move(world));
        job.view.scene.output.layers = core::PictureLayers::kAll;
        const output::Film film = test::render_scene(job, 1);
        // Of pixels that see the sand, which lies under the leaves.
        double sum = 0;
        int count = 0;
        for (int y = 0; y < film.height_px(); ++y)
            for (int x = 0; x < film.width_px(); ++x) {
                const tiles::LayerSample& layers = film.layers_at(x, y);
                if (layers.material != Material::kSand)
                    continue;
                sum += static_cast<double>(voxel::luminance(film.at(x, y).colour));
                ++count;
            }
        INFO(kind.name << ": " << count << " pixels of sand");
        REQUIRE(count > 100);
        INFO("mean " << sum / count);
        CHECK(sum / count > 0.02);
    }
}

TEST_CASE("water's own light is counted once, however many leaves a ray passes in it",
          "[raytracer][shade]") {
    const Job job(small_scene());
    const auto shading = shade::make_shading(job.view);
    int passed = 0;
    for (std::uint32_t sample = 0; sample < 64; ++sample) {
        walk::TracedRay ray = met(*shading, Material::kHighVegetation, core::Face::kTop);
        ray.kind = walk::RayKind::kRefracted;
        ray.medium = Material::kWater;
        ray.ray.origin = ray.ray.origin + core::Vec3{0.006 * sample, 0, 0.004 * sample};
        const Shaded out = shade_rays(*shading, ray, sample);
        if (out.next.size() != 1 || out.next[0].kind != walk::RayKind::kRefracted)
            continue;
        ++passed;
        CHECK(voxel::luminance(out.sum.direct + out.sum.indirect) == 0);
    }
    CHECK(passed > 0);
}

TEST_CASE("without reflections all light goes into the water", "[raytracer][shade]") {
    for (const core::Integrator integrator : {core::Integrator::kDirect, core::Integrator::kPath}) {
        scene::Scene scene = small_scene();
        scene.quality.reflections = false;
        scene.quality.integrator = integrator;
        const Job job(scene);
        const auto shading = shade::make_shading(job.view);
        for (std::uint32_t sample = 0; sample < 16; ++sample) {
            const Shaded out = shade_rays(
                *shading,
                met(*shading, Material::kWater, core::Face::kTop, core::normalized({1, -0.1, 0.2})),
                sample);
            REQUIRE(out.next.size() == 1);
            CHECK(out.next[0].kind == walk::RayKind::kRefracted);
            // But for the air before it.
            CHECK(out.next[0].weight.g > 0.9f);
        }
    }
}

TEST_CASE("a path out of the water does not count the sun that was sampled at the bed",
          "[raytracer][shade]") {
    scene::Scene scene = small_scene();
    scene.quality.integrator = core::Integrator::kPath;
    scene.quality.clamp = 0;
    const Job job(scene);
    const auto shading = shade::make_shading(job.view);
    walk::TracedRay ray = met(*shading, Material::kSand, core::Face::kTop);
    ray.medium = Material::kWater;
    bool found = false;
    for (const walk::TracedRay& sent : shade_rays(*shading, ray).next) {
        if (sent.kind != walk::RayKind::kBounce)
            continue;
        found = true;
        walk::TracedRay up = sent;  // at the water's surface, on its way to the sun
        up.ray.direction = core::normalized({0.02, 1, 0.03});
        up.end = walk::WalkEnd::kHit;
        up.hit.face = core::Face::kBottom;
        up.hit.attr.material = Material::kAir;
        up.hit.t = 1;
        for (std::uint32_t sample = 0; sample < 64; ++sample)
            for (walk::TracedRay out : shade_rays(*shading, up, sample).next) {
                if (out.kind != walk::RayKind::kRefracted)
                    continue;
                out.end = walk::WalkEnd::kMiss;
                out.ray.direction = job.view.sky.to_sun();
                walk::TracedRay free = out;
                free.sun_counted = false;
                CHECK(voxel::luminance(shade_rays(*shading, free).sum.indirect) >
                      100 * voxel::luminance(shade_rays(*shading, out).sum.indirect));
            }
    }
    CHECK(found);
}
