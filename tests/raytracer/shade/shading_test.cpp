#include "raytracer/shade/shading.hpp"

#include "raytracer/walk/walker.hpp"
#include "tests/catch.hpp"
#include "tests/raytracer/landscape.hpp"

using namespace terravox;
using terravox::test::Job;
using terravox::test::small_scene;
using voxel::Material;

namespace {

/// A ray from (0.3, 10.4, 0.6) that has met a face of the voxel (0, 4, 0), or a voxel around its
/// own start.
TracedRay met(const Shading& shading, Material material, Face face,
              Vec3 direction = normalized({0.02, -1, 0.03})) {
    TracedRay ray = shading.primary({{0.3, 10.4, 0.6}, direction}, 0);
    ray.footprint = 0.01f, ray.spread = 0;
    ray.end = WalkEnd::kHit;
    ray.hit.face = face, ray.hit.attr.material = material;
    ray.hit.t = face == Face::kNone ? 0 : -5.4 / direction.y;
    ray.hit.voxel = face == Face::kNone ? VoxelCoord{0, 10, 0} : VoxelCoord{0, 4, 0};
    return ray;
}

struct Shaded {
    SampleSum sum;
    std::vector<TracedRay> next;
};
Shaded shade(const Shading& shading, const TracedRay& ray, std::uint32_t sample = 0) {
    Shaded out;
    out.sum.numbers = Sampler(3, 7, sample);
    shading.shade(ray, out.sum, out.next);
    return out;
}

}  // namespace

TEST_CASE(
    "a ray that asks for light comes out of the leaves that it starts in, and out of nothing else",
    "[raytracer][shade]") {
    const Job job(small_scene());
    const auto shading = make_shading(job.view);
    for (const RayKind kind : {RayKind::kShadow, RayKind::kSky, RayKind::kAmbient}) {
        INFO(name_of(kind));
        for (const Material material : {Material::kHighVegetation, Material::kRock}) {
            TracedRay ray = met(*shading, material, Face::kNone);
            ray.kind = kind, ray.leaves = true;
            const Shaded out = shade(*shading, ray);
            CHECK(luminance(out.sum.direct) == 0);
            REQUIRE(out.next.size() == (material == Material::kHighVegetation ? 1 : 0));
            if (out.next.empty())
                continue;
            CHECK(out.next[0].end == WalkEnd::kWaits);
            CHECK(out.next[0].state.voxel[1] == 9);
        }
    }
}

TEST_CASE("a mixed colour is not that of what stands beside the voxel", "[raytracer][shade]") {
    const voxel::Rgb8 lake{40, 110, 125}, meadow{90, 120, 60}, shade{45, 55, 58}, roof{170, 80, 60};
    struct Case {
        const char* name;
        Material material;
        voxel::Rgb8 photo;
        VoxelColour colour;
        float least, most;  ///< share of the photo in what is shown
    };
    for (const Case& c :
         {Case{"a meadow", Material::kGrass, meadow, VoxelColour::kMix, 0.84f, 0.86f},
          Case{"a shore that shows the lake", Material::kGrass, lake, VoxelColour::kMix, 0, 0.001f},
          Case{"leaves over the lake", Material::kHighVegetation, lake, VoxelColour::kMix, 0,
               0.001f},
          Case{"leaves in the shade", Material::kHighVegetation, shade, VoxelColour::kMix, 0.5f,
               0.86f},
          Case{"the lake itself", Material::kConcrete, lake, VoxelColour::kMix, 0.84f, 0.86f},
          Case{"a wall that shows the roof", Material::kWall, roof, VoxelColour::kMix, 0, 0.001f},
          Case{"a wall, as the photo has it", Material::kWall, roof, VoxelColour::kTrue, 0.999f,
               1.001f},
          Case{"a shore, as the photo has it", Material::kGrass, lake, VoxelColour::kTrue, 0.999f,
               1.001f}}) {
        INFO(c.name);
        Scene scene = small_scene();
        scene.quality.colour = c.colour, scene.quality.textures = false;
        const Job job(scene);
        const auto shading = make_shading(job.view);
        TracedRay ray = met(*shading, c.material, Face::kTop);
        const Colour plain = surface_at(job.view, ray).albedo;
        ray.hit.attr.colour = c.photo, ray.hit.attr.flags = voxel::VoxelAttr::kHasColour;
        const Colour shown = surface_at(job.view, ray).albedo;
        scene.quality.colour = VoxelColour::kTrue;
        const Job photo_job(scene);
        const Colour photo = surface_at(photo_job.view, ray).albedo;
        const float share = (shown.g - plain.g) / (photo.g - plain.g);
        CHECK(share >= c.least);
        CHECK(share <= c.most);
    }
}

TEST_CASE("faces between leaves get light, whoever asks for it", "[raytracer][shade]") {
    struct Kind {
        const char* name;
        void (*set)(Scene&);
    };
    const Kind kinds[] = {
        {"sun", [](Scene& s) { s.sky.strength = 0; }},
        {"ambient occlusion", [](Scene& s) { s.quality.ao_rays = 4, s.sun.strength = 0; }},
        {"paths", [](Scene& s) { s.quality.integrator = Integrator::kPath, s.sun.strength = 0; }},
    };
    for (const Kind& kind : kinds) {
        Scene scene = small_scene();
        scene.output.size_px = {64, 64};
        scene.quality.samples = 1, scene.quality.bounces = 0;
        scene.sun.altitude_deg = 70;
        scene.camera.space = CoordinateSpace::kVoxel, scene.camera.position = {{0.5, 5, 0.5}},
        scene.camera.target = {{0.6, 0, 0.6}};
        kind.set(scene);
        auto world = std::make_unique<test::ArrayWorld>(test::ArrayWorld::Coord{-20, -4, -20},
                                                        test::ArrayWorld::Coord{20, 8, 20});
        world->fill({-20, -4, -20}, {20, 0, 20}, Material::kSand);
        world->fill({-20, 0, -20}, {20, 1, 20}, Material::kLowVegetation);
        world->editable_info().bounds = world->level_bounds();
        Job job(scene, std::size_t{64} << 20, std::move(world));
        job.view.scene.output.layers = PictureLayers::kAll;
        const Film film = test::render(job, 1);
        // Of pixels that see the sand, which lies under the leaves.
        double sum = 0;
        int count = 0;
        for (int y = 0; y < film.height_px(); ++y)
            for (int x = 0; x < film.width_px(); ++x) {
                const LayerSample& layers = film.layers_at(x, y);
                if (layers.material != Material::kSand)
                    continue;
                sum += static_cast<double>(luminance(film.at(x, y).colour)), ++count;
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
    const auto shading = make_shading(job.view);
    int passed = 0;
    for (std::uint32_t sample = 0; sample < 64; ++sample) {
        TracedRay ray = met(*shading, Material::kHighVegetation, Face::kTop);
        ray.kind = RayKind::kRefracted, ray.medium = Material::kWater;
        ray.ray.origin = ray.ray.origin + Vec3{0.006 * sample, 0, 0.004 * sample};
        const Shaded out = shade(*shading, ray, sample);
        if (out.next.size() != 1 || out.next[0].kind != RayKind::kRefracted)
            continue;
        ++passed;
        CHECK(luminance(out.sum.direct + out.sum.indirect) == 0);
    }
    CHECK(passed > 0);
}

TEST_CASE("without reflections all light goes into the water", "[raytracer][shade]") {
    for (const Integrator integrator : {Integrator::kDirect, Integrator::kPath}) {
        Scene scene = small_scene();
        scene.quality.reflections = false, scene.quality.integrator = integrator;
        const Job job(scene);
        const auto shading = make_shading(job.view);
        for (std::uint32_t sample = 0; sample < 16; ++sample) {
            const Shaded out = shade(
                *shading, met(*shading, Material::kWater, Face::kTop, normalized({1, -0.1, 0.2})),
                sample);
            REQUIRE(out.next.size() == 1);
            CHECK(out.next[0].kind == RayKind::kRefracted);
            // But for the air before it.
            CHECK(out.next[0].weight.g > 0.9f);
        }
    }
}

TEST_CASE("a path out of the water does not count the sun that its bed has asked for",
          "[raytracer][shade]") {
    Scene scene = small_scene();
    scene.quality.integrator = Integrator::kPath, scene.quality.clamp = 0;
    const Job job(scene);
    const auto shading = make_shading(job.view);
    TracedRay ray = met(*shading, Material::kSand, Face::kTop);
    ray.medium = Material::kWater;
    bool found = false;
    for (const TracedRay& sent : shade(*shading, ray).next) {
        if (sent.kind != RayKind::kBounce)
            continue;
        found = true;
        TracedRay up = sent;  // at the water's surface, on its way to the sun
        up.ray.direction = normalized({0.02, 1, 0.03});
        up.end = WalkEnd::kHit;
        up.hit.face = Face::kBottom, up.hit.attr.material = Material::kAir, up.hit.t = 1;
        for (std::uint32_t sample = 0; sample < 64; ++sample)
            for (TracedRay out : shade(*shading, up, sample).next) {
                if (out.kind != RayKind::kRefracted)
                    continue;
                out.end = WalkEnd::kMiss;
                out.ray.direction = job.view.sky.to_sun();
                TracedRay free = out;
                free.sun_asked = false;
                CHECK(luminance(shade(*shading, free).sum.indirect) >
                      100 * luminance(shade(*shading, out).sum.indirect));
            }
    }
    CHECK(found);
}
