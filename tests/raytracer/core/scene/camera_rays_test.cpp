#include <algorithm>
#include <cmath>

#include "raytracer/core/scene/camera.hpp"
#include "raytracer/core/walk/level_cut.hpp"
#include "raytracer/farm/render/passes/passes.hpp"
#include "tests/catch.hpp"
#include "tests/raytracer/core/scene/some_cameras.hpp"
#include "tests/raytracer/scene_words_text.hpp"

using namespace terravox;
using namespace terravox::test;

TEST_CASE("rays through all points of the lens meet where it is sharp, and start within it",
          "[raytracer][camera][lens]") {
    const auto projection =
        GENERATE(core::CameraProjection::kPerspective, core::CameraProjection::kOrthographic,
                 core::CameraProjection::kIsometric);
    Random random(6);
    for (int run = 0; run < 200; ++run) {
        scene::Scene scene = placed(random, projection);
        const double voxel_m = random.in(0.2, 2);
        scene.camera.aperture_m = random.in(0.01, 30);
        if (run % 2 == 0)
            scene.camera.focus_m = random.in(1, 3000);
        const scene::Camera camera = scene::make_camera(scene, slovenia(voxel_m), kWorldBounds);
        const double px = random.in(0, scene.output.size_px[0]);
        const double py = random.in(0, scene.output.size_px[1]);
        INFO(projection << " run " << run << ", aperture " << scene.camera.aperture_m << ", focus "
                        << scene.camera.focus_m.value_or(-1));
        const auto &p = *scene.camera.position, &t = *scene.camera.target;
        const core::Vec3 place{p[0], p[1], p[2]};
        const core::Vec3 target{t[0], t[1], t[2]};
        // The distance of the plane of focus from where rays start.
        const double distance =
            scene.camera.focus_m ? *scene.camera.focus_m / voxel_m : core::length(target - place);
        double depth = distance;
        if (projection == core::CameraProjection::kOrthographic)
            depth += core::dot(place - camera.position(), camera.forward());
        if (projection == core::CameraProjection::kIsometric && !scene.camera.focus_m)
            depth = core::dot(target - camera.position(), camera.forward());
        const core::Ray middle = camera.ray(px, py);
        const core::Vec3 sharp =
            middle.origin +
            middle.direction * (depth / core::dot(middle.direction, camera.forward()));
        REQUIRE_FALSE(camera.pinhole());
        double widest = 0;
        for (int i = 0; i < 30; ++i) {
            const auto ray = camera.ray(px, py, random.in(0, 1), random.in(0, 1));
            REQUIRE(ray);
            REQUIRE(std::abs(core::length(ray->direction) - 1) < 1e-14);
            REQUIRE(core::length(core::cross(sharp - ray->origin, ray->direction)) <
                    1e-8 * (1 + core::length(sharp - ray->origin)));
            REQUIRE(std::abs(core::dot(ray->origin - camera.position(), camera.forward())) <
                    1e-8 * (1 + core::length(ray->origin)));
            if (projection == core::CameraProjection::kPerspective)
                widest = std::max(widest, core::length(ray->origin - middle.origin));
        }
        REQUIRE(widest <= scene.camera.aperture_m / 2 / voxel_m * (1 + 1e-9));
    }
}

TEST_CASE("points of the lens fill the disc evenly", "[raytracer][camera][lens]") {
    constexpr int kSide = 200;
    std::array<int, 4> quadrants{};
    double within_half = 0;
    double sum_x = 0;
    double sum_y = 0;
    for (int i = 0; i < kSide; ++i)
        for (int j = 0; j < kSide; ++j) {
            const auto [x, y] = scene::concentric_disc((i + 0.5) / kSide, (j + 0.5) / kSide);
            REQUIRE(x * x + y * y <= 1);
            ++quadrants[static_cast<std::size_t>((x > 0) + 2 * (y > 0))];
            within_half += x * x + y * y < 0.25;
            sum_x += x;
            sum_y += y;
        }
    for (const int n : quadrants)
        CHECK(n == kSide * kSide / 4);
    CHECK(within_half / (kSide * kSide) == Approx(0.25).epsilon(0.01));
    CHECK(std::abs(sum_x) + std::abs(sum_y) < 1e-9);
    CHECK(scene::concentric_disc(0.5, 0.5) == std::array<double, 2>{0, 0});
    CHECK(scene::concentric_disc(0, 0.5)[0] == Approx(-1));
}

TEST_CASE("the camera turns clockwise about its line of sight", "[raytracer][camera]") {
    const auto projection =
        GENERATE(core::CameraProjection::kPerspective, core::CameraProjection::kOrthographic,
                 core::CameraProjection::kFisheye);
    scene::Scene scene = make_scene(projection, 400, 400);
    scene.camera.space = core::CoordinateSpace::kVoxel;
    scene.camera.position = {0, 50, 900};
    scene.camera.target = {0, 50, 0};
    scene.camera.roll_deg = 90;
    const scene::Camera camera = scene::make_camera(scene, {}, kWorldBounds);
    // It looks north; its upper edge now is in the east.
    const core::Ray up = camera.ray(200, 10);
    const core::Ray middle = camera.ray(200, 200);
    const core::Vec3 way = up.origin - middle.origin + (up.direction - middle.direction);
    CHECK(way.x > 0.1);
    CHECK(std::abs(way.y) < 1e-9 * (1 + way.x));
}

TEST_CASE("a map camera's geotransform says where its rays hit",
          "[raytracer][camera][geotransform]") {
    Random random(7);
    for (int run = 0; run < 200; ++run) {
        const double voxel_m = random.in(0.2, 3);
        voxel::WorldInfo world = slovenia(voxel_m);
        if (run % 3 == 0)
            world.crs_units_per_voxel = voxel_m * 1.44;
        scene::Scene scene = make_scene(core::CameraProjection::kOrthographic,
                                        1 + static_cast<int>(random.in(0, 900)),
                                        1 + static_cast<int>(random.in(0, 900)));
        scene.camera.down_deg = 90;
        scene.camera.azimuth_deg = random.in(-360, 360);
        scene.camera.roll_deg = run % 2 == 0 ? 0 : random.in(-180, 180);
        if (run % 5 == 0) {
            scene.camera.position = {462'000.25, 101'000.5, 900};
            scene.camera.target = {462'000.25, 101'000.5, 200};
        }
        const scene::Camera camera = scene::make_camera(scene, world, kWorldBounds);
        const auto g = camera.geotransform(world);
        REQUIRE(g);
        for (int i = 0; i < 20; ++i) {
            const double px = random.in(0, scene.output.size_px[0]);
            const double py = random.in(0, scene.output.size_px[1]);
            const core::Ray ray = camera.ray(px, py);
            const core::Vec3 hit =
                ray.origin + ray.direction * ((random.in(0, 300) - ray.origin.y) / ray.direction.y);
            INFO("run " << run << " at " << px << ", " << py);
            REQUIRE((*g)[0] + px * (*g)[1] + py * (*g)[2] ==
                    Approx(hit.x * world.crs_units_per_voxel).margin(1e-6).epsilon(0));
            REQUIRE((*g)[3] + px * (*g)[4] + py * (*g)[5] ==
                    Approx(-hit.z * world.crs_units_per_voxel).margin(1e-6).epsilon(0));
        }
        // North is up unless it is turned.
        if (scene.camera.roll_deg == 0)
            REQUIRE(((*g)[1] > 0 && (*g)[2] == 0 && (*g)[4] == 0 && (*g)[5] < 0));
        CHECK_FALSE(camera.geotransform(voxel::WorldInfo{}));
    }
    scene::Scene scene = make_scene(core::CameraProjection::kOrthographic);
    scene.camera.down_deg = 89;
    CHECK_FALSE(scene::make_camera(scene, slovenia(), kWorldBounds).geotransform(slovenia()));
    CHECK_FALSE(
        scene::make_camera(make_scene(core::CameraProjection::kIsometric), slovenia(), kWorldBounds)
            .geotransform(slovenia()));
    scene.camera.down_deg = 90;
    scene.camera.projection = core::CameraProjection::kPerspective;
    CHECK_FALSE(scene::make_camera(scene, slovenia(), kWorldBounds).geotransform(slovenia()));
}

TEST_CASE("matrices take a point on a pixel's ray to that pixel", "[raytracer][camera][matrices]") {
    const auto projection =
        GENERATE(core::CameraProjection::kPerspective, core::CameraProjection::kOrthographic,
                 core::CameraProjection::kIsometric);
    Random random(8);
    for (int run = 0; run < 200; ++run) {
        const double voxel_m = random.in(0.2, 3);
        const scene::Scene scene = placed(random, projection);
        const scene::Camera camera = scene::make_camera(scene, slovenia(voxel_m), kWorldBounds);
        const auto origin = camera.picture_origin();
        const auto to_camera = camera.world_to_camera();
        const auto to_ndc = camera.world_to_ndc();
        REQUIRE(to_ndc);
        const auto times = [](const std::array<double, 4>& p, const std::array<double, 16>& m) {
            std::array<double, 4> out{};
            for (std::size_t c = 0; c < 4; ++c)
                for (std::size_t r = 0; r < 4; ++r)
                    out[c] += p[r] * m[r * 4 + c];
            return out;
        };
        const double w = scene.output.size_px[0];
        const double h = scene.output.size_px[1];
        for (int i = 0; i < 10; ++i) {
            const double px = random.in(0, w);
            const double py = random.in(0, h);
            const double t = random.in(1, 2000);
            const core::Ray ray = camera.ray(px, py);
            const core::Vec3 at = ray.origin + ray.direction * t;
            const std::array<double, 4> world{(at.x - static_cast<double>(origin[0])) * voxel_m,
                                              (at.y - static_cast<double>(origin[1])) * voxel_m,
                                              (at.z - static_cast<double>(origin[2])) * voxel_m, 1};
            const auto seen = times(world, to_camera);
            const auto ndc = times(world, *to_ndc);
            INFO(projection << " run " << run << " at " << px << ", " << py << ", t " << t);
            const double depth_m = core::dot(ray.direction, camera.forward()) * t * voxel_m;
            REQUIRE(seen[2] == Approx(-depth_m).epsilon(1e-7));
            REQUIRE(seen[3] == 1);
            REQUIRE(std::sqrt(seen[0] * seen[0] + seen[1] * seen[1] + seen[2] * seen[2]) ==
                    Approx(core::length(at - camera.position()) * voxel_m).epsilon(1e-7));
            REQUIRE(ndc[0] / ndc[3] == Approx(px / w).margin(1e-6));
            REQUIRE(ndc[1] / ndc[3] == Approx(py / h).margin(1e-6));
            REQUIRE(
                ndc[2] / ndc[3] ==
                Approx(projection == core::CameraProjection::kPerspective ? 1 / depth_m : depth_m)
                    .epsilon(1e-7));
        }
    }
    CHECK_FALSE(scene::make_camera(make_scene(core::CameraProjection::kPanorama), {}, kWorldBounds)
                    .world_to_ndc());
    CHECK_FALSE(scene::make_camera(make_scene(core::CameraProjection::kFisheye), {}, kWorldBounds)
                    .world_to_ndc());
}

TEST_CASE("parallel rays see one level everywhere; other cameras coarser ones farther away",
          "[raytracer][camera][levels]") {
    scene::Scene scene = make_scene(core::CameraProjection::kOrthographic, 100, 100);
    const auto level_at = [&](double height_m, double detail) {
        scene.camera.height_m = height_m;
        const walk::LevelCut cut(kWorldBounds, scene::make_camera(scene, slovenia(), kWorldBounds),
                                 detail, 0, 5);
        const int level = cut.level_at(0, 100, 0);
        for (int x = -300; x < 1200; x += 64)
            CHECK(cut.level_at(x, 500, 3) == level);
        return level;
    };
    CHECK(level_at(100, 1) == 0);  // a voxel is a pixel
    CHECK(level_at(199, 1) == 0);
    CHECK(level_at(200, 1) == 1);
    CHECK(level_at(800, 1) == 3);
    CHECK(level_at(800, 2) == 4);
    CHECK(level_at(800, 0) == 0);  // the finest
    CHECK(level_at(1e6, 1) == 5);  // the coarsest
    for (const core::CameraProjection projection :
         {core::CameraProjection::kPerspective, core::CameraProjection::kPanorama,
          core::CameraProjection::kFisheye}) {
        scene::Scene other = make_scene(projection, 100, 50);
        const scene::Camera camera = scene::make_camera(other, slovenia(), kWorldBounds);
        const walk::LevelCut cut(kWorldBounds, camera, 1, 0, 5),
            same(kWorldBounds, camera.position(), camera.pixel_rad(), 1, 0, 5);
        for (int x = -300; x < 1200; x += 16)
            for (int z = 40; z < 800; z += 16)
                REQUIRE(cut.level_at(x, z, 0) == same.level_at(x, z, 0));
    }
}

TEST_CASE("every box that a ray goes through is in sight", "[raytracer][camera][levels]") {
    const auto projection =
        GENERATE(core::CameraProjection::kPerspective, core::CameraProjection::kOrthographic,
                 core::CameraProjection::kIsometric, core::CameraProjection::kPanorama,
                 core::CameraProjection::kFisheye);
    Random random(9);
    constexpr voxel::VoxelBounds kWide{{-2000, 0, -2000}, {2000, 256, 2000}};
    std::size_t fewest = 100'000;
    for (int run = 0; run < 40; ++run) {
        scene::Scene scene = placed(random, projection);
        if (run % 2 == 0)
            scene.camera.height_m = random.in(50, 900);
        if (projection == core::CameraProjection::kFisheye && run % 2 == 0)
            scene.camera.fov_deg = random.in(5, 60);
        const scene::Camera camera = scene::make_camera(scene, {}, kWide);
        const walk::LevelCut cut(kWide, camera, 0, 0, 0);
        const auto keys = render::boxes_in_sight(camera, scene.output.size_px[0],
                                                 scene.output.size_px[1], cut, 100'000);
        std::vector<voxel::BoxKey> sorted = keys;
        const auto less = [](const voxel::BoxKey& a, const voxel::BoxKey& b) {
            return a.bx != b.bx ? a.bx < b.bx : a.bz < b.bz;
        };
        std::sort(sorted.begin(), sorted.end(), less);
        fewest = std::min(fewest, keys.size());
        for (int i = 0; i < 50; ++i) {
            const double px = random.in(0, scene.output.size_px[0]);
            const double py = random.in(0, scene.output.size_px[1]);
            if (!camera.sees(px, py))
                continue;
            const core::Ray ray = camera.ray(px, py);
            for (double t = 0; t < 6000; t += 31) {
                const core::Vec3 at = ray.origin + ray.direction * t;
                if (at.x < -2000 || at.x >= 2000 || at.z < -2000 || at.z >= 2000 || at.y < 0 ||
                    at.y >= 256)
                    continue;
                const voxel::BoxKey key{0, static_cast<std::int32_t>(std::floor(at.x / 64)), 0,
                                        static_cast<std::int32_t>(std::floor(at.z / 64))};
                INFO(projection << " run " << run << ", box " << key.bx << ", " << key.bz);
                REQUIRE(std::binary_search(sorted.begin(), sorted.end(), key, less));
            }
        }
    }
    if (projection != core::CameraProjection::kPanorama)
        CHECK(fewest < 2000);  // of 3969 columns: not simply all
}

namespace {

/// Bounds of a world without end, some hundred voxels high.
constexpr std::int32_t kHalf = 1 << 24;
constexpr voxel::VoxelBounds kEndless{{-kHalf, -100, -kHalf}, {kHalf, 200, kHalf}};

}  // namespace

TEST_CASE("a picture of a world without end shows it as far as its height covers a pixel",
          "[raytracer][camera][levels]") {
    constexpr int kSize_px = 1000;
    for (const double height : {50.0, 150.0, 5000.0}) {
        const scene::Camera camera({1000, height, -70}, {5000, 0, 0}, 50, kSize_px, kSize_px);
        const voxel::VoxelBounds seen = walk::within_horizon(kEndless, camera);
        INFO("eye at " << height << ", seen from x = " << seen.min[0] << " to " << seen.max[0]);
        CHECK(seen.min[1] == kEndless.min[1]);
        CHECK(seen.max[1] == kEndless.max[1]);
        CHECK(seen.min[0] + seen.max[0] == 2000);
        CHECK(seen.min[2] + seen.max[2] == -140);
        const double highest = std::max(height, 200.0) + 100;
        CHECK((seen.max[0] - 1000) * camera.pixel_rad() == Approx(highest).epsilon(1e-4));
        // So the coarsest voxels are no higher than the land and the eye above it.
        const walk::LevelCut cut(seen, camera, 1, 0, 19);
        CHECK(std::ldexp(1.0, cut.coarsest()) <= highest * std::sqrt(2.0));
        CHECK(cut.entry_bounds().max[1] <= 200 + (1 << cut.coarsest()));
    }
    const scene::Camera near({0, 50, 0}, {100, 0, 0}, 50, 100, 100);
    CHECK(walk::within_horizon(kWorldBounds, near) == kWorldBounds);
    const scene::Camera beyond({1e8, 50, 0}, {0, 0, 0}, 50, 100, 100);
    CHECK(walk::within_horizon(kEndless, beyond) == kEndless);
    const scene::Camera parallel = scene::make_camera(
        make_scene(core::CameraProjection::kOrthographic, 100, 100), {}, kWorldBounds);
    CHECK(walk::within_horizon(kEndless, parallel) == kEndless);
}

TEST_CASE("the space below a world is not in sight", "[raytracer][camera][levels]") {
    // The uppermost rays look 15 degrees down, and leave the world 2240 voxels away.
    const scene::Camera camera({0, 500, 0}, {0, 0, -714}, 40, 1280, 720);
    const walk::LevelCut cut(kEndless, camera, 1, 0, 19);
    const auto keys = render::boxes_in_sight(camera, 1280, 720, cut, 65'536);
    CHECK(keys.size() > 500);
    CHECK(keys.size() < 5000);
    for (const voxel::BoxKey& key : keys)
        REQUIRE(key.level <= 1);
}
