#include <algorithm>
#include <cmath>

#include "common/util/error.hpp"
#include "raytracer/core/scene/camera.hpp"
#include "tests/catch.hpp"
#include "tests/raytracer/core/scene/some_cameras.hpp"
#include "tests/raytracer/scene_words_text.hpp"

using namespace terravox;
using namespace terravox::test;

TEST_CASE(
    "every projection: rays have unit length, the middle of the picture looks forward, the way "
    "that was asked for",
    "[raytracer][camera]") {
    const auto projection =
        GENERATE(core::CameraProjection::kPerspective, core::CameraProjection::kOrthographic,
                 core::CameraProjection::kIsometric, core::CameraProjection::kPanorama,
                 core::CameraProjection::kFisheye);
    Random random(1);
    for (int run = 0; run < 300; ++run) {
        const scene::Scene scene = placed(random, projection);
        const scene::Camera camera = scene::make_camera(scene, slovenia(), kWorldBounds);
        const double w = scene.output.size_px[0];
        const double h = scene.output.size_px[1];
        INFO(projection << " run " << run << ", " << w << " x " << h << ", fov "
                        << scene.camera.fov_deg << ", forward " << to_text(camera.forward()));
        const core::Ray middle = camera.ray(w / 2, h / 2);
        REQUIRE(core::length(middle.direction - camera.forward()) < 1e-14);
        REQUIRE(core::length(middle.origin - camera.position()) < 1e-9);
        for (int i = 0; i < 20; ++i) {
            const double px = random.in(0, w);
            const double py = random.in(0, h);
            REQUIRE(std::abs(core::length(camera.ray(px, py).direction) - 1) < 1e-14);
            const auto through_lens = camera.ray(px, py, random.in(0, 1), random.in(0, 1));
            REQUIRE(through_lens.has_value() == camera.sees(px, py));
            if (through_lens)
                REQUIRE(core::length(through_lens->direction - camera.ray(px, py).direction) ==
                        0);  // no aperture
        }
        const auto &p = *scene.camera.position, &t = *scene.camera.target;
        const core::Vec3 sight = core::normalized({t[0] - p[0], t[1] - p[1], t[2] - p[2]});
        if (projection == core::CameraProjection::kPanorama)
            REQUIRE(core::length(camera.forward() - core::normalized({sight.x, 0, sight.z})) <
                    1e-9);
        else if (projection != core::CameraProjection::kIsometric)
            REQUIRE(core::length(camera.forward() - sight) < 1e-12);
        // The picture's middle: the target lies behind it.
        if (projection == core::CameraProjection::kOrthographic ||
            projection == core::CameraProjection::kIsometric)
            REQUIRE(core::length(core::cross(core::Vec3{t[0], t[1], t[2]} - middle.origin,
                                             middle.direction)) < 1e-6);
        REQUIRE(camera.pinhole() == (projection == core::CameraProjection::kPerspective));
    }
}

TEST_CASE(
    "a panorama goes once around, evenly, upright, and is whole when it is twice as wide as high",
    "[raytracer][camera][panorama]") {
    scene::Scene scene = make_scene(core::CameraProjection::kPanorama, 720, 360);
    scene.camera.space = core::CoordinateSpace::kVoxel;
    scene.camera.position = {0, 100, 0};
    scene.camera.target = {30, 60, -40};
    const scene::Camera camera = scene::make_camera(scene, {}, kWorldBounds);
    for (int x = 0; x <= 720; x += 5)
        for (int y = 0; y <= 360; y += 5) {
            const core::Vec3 d = camera.ray(x, y).direction;
            INFO(x << ", " << y << ": " << to_text(d));
            REQUIRE(camera.sees(x, y));
            REQUIRE(std::asin(std::clamp(d.y, -1.0, 1.0)) ==
                    Approx((180 - y) * kPi / 360).margin(1e-7));
            if (y == 0 || y == 360)
                continue;
            const double ahead = std::atan2(30, 40),
                         azimuth = std::atan2(d.x, -d.z);  // from north, clockwise
            REQUIRE(std::cos(azimuth - ahead - (x - 360) * kPi / 360) > 1 - 1e-12);
        }
    // Pixels weighted with the area that they cover add up to the whole sphere, and to nothing on
    // either side.
    double area = 0;
    core::Vec3 sum;
    for (int y = 0; y < 360; ++y)
        for (int x = 0; x < 720; ++x) {
            const core::Vec3 d = camera.ray(x + 0.5, y + 0.5).direction;
            const double cover = camera.pixel_rad() * camera.pixel_rad() * std::sqrt(1 - d.y * d.y);
            area += cover;
            sum = sum + d * cover;
        }
    CHECK(area == Approx(4 * kPi).epsilon(1e-4));
    CHECK(core::length(sum) < 1e-9);
    SECTION("wider, it is a band around the horizon; higher, there is nothing beyond the poles") {
        scene.output.size_px = {720, 90};
        const scene::Camera band = scene::make_camera(scene, {}, kWorldBounds);
        CHECK(std::asin(band.ray(360, 0).direction.y) == Approx(kPi / 8));
        scene.output.size_px = {720, 500};
        const scene::Camera high = scene::make_camera(scene, {}, kWorldBounds);
        CHECK_FALSE(high.sees(10, 69.5));
        CHECK(high.sees(10, 70.5));
        CHECK(high.sees(10, 429.5));
        CHECK_FALSE(high.sees(10, 430.5));
        CHECK_FALSE(high.ray(10, 499, 0.5, 0.5));
    }
    SECTION("looking straight down it looks north") {
        scene.camera.target = {0, 50, 0};
        CHECK(core::length(scene::make_camera(scene, {}, kWorldBounds).forward() -
                           core::Vec3{0, 0, -1}) == 0);
    }
}

TEST_CASE(
    "in a fisheye the angle to the line of sight grows evenly, and nothing is outside its circle",
    "[raytracer][camera][fisheye]") {
    const double fov = GENERATE(1.0, 90.0, 180.0, 220.0, 360.0);
    const auto size = GENERATE(values<std::array<int, 2>>({{400, 300}, {300, 400}, {300, 300}}));
    scene::Scene scene = make_scene(core::CameraProjection::kFisheye, size[0], size[1]);
    scene.camera.space = core::CoordinateSpace::kVoxel;
    scene.camera.position = {0, 100, 0};
    scene.camera.target = {30, 60, -40};
    scene.camera.fov_deg = fov;
    scene.camera.roll_deg = 25;
    const scene::Camera camera = scene::make_camera(scene, {}, kWorldBounds);
    const double radius = 150;
    Random random(3);
    for (int i = 0; i < 500; ++i) {
        const double r = random.in(0, 1.4) * radius;
        const double turn = random.in(0, 2 * kPi);
        const double px = size[0] / 2.0 + r * std::cos(turn);
        const double py = size[1] / 2.0 - r * std::sin(turn);
        INFO("fov " << fov << ", r " << r << ", turn " << turn);
        if (std::abs(r - radius) > 1e-9)
            REQUIRE(camera.sees(px, py) == (r < radius));
        if (r >= radius)
            continue;
        const core::Vec3 d = camera.ray(px, py).direction;
        REQUIRE(angle_between(d, camera.forward()) ==
                Approx(r / radius * fov / 2 * kPi / 180).margin(1e-7));
    }
    // A small step from the middle goes where the same step of a perspective goes.
    scene.camera.projection = core::CameraProjection::kPerspective;
    scene.camera.fov_deg = 40;
    const scene::Camera flat = scene::make_camera(scene, {}, kWorldBounds);
    const auto across = [&](const scene::Camera& c, double dx, double dy) {
        const core::Vec3 d = c.ray(size[0] / 2.0 + dx, size[1] / 2.0 + dy).direction - c.forward();
        return core::normalized(d - c.forward() * core::dot(d, c.forward()));
    };
    CHECK(core::length(across(camera, 1e-3, 0) - across(flat, 1e-3, 0)) < 1e-4);
    CHECK(core::length(across(camera, 0, 1e-3) - across(flat, 0, 1e-3)) < 1e-4);
}

TEST_CASE(
    "orthographic rays are parallel, spaced by the height over the pixels, and start before "
    "everything",
    "[raytracer][camera][orthographic]") {
    const auto projection =
        GENERATE(core::CameraProjection::kOrthographic, core::CameraProjection::kIsometric);
    Random random(4);
    for (int run = 0; run < 200; ++run) {
        scene::Scene scene = placed(random, projection);
        const double height_m = random.in(0.5, 2000);
        const double voxel_m = random.in(0.1, 3);
        scene.camera.height_m = height_m;
        const voxel::WorldInfo world = slovenia(voxel_m);
        const scene::Camera camera = scene::make_camera(scene, world, kWorldBounds);
        INFO(projection << " run " << run << ", forward " << to_text(camera.forward()) << ", from "
                        << to_text(camera.position()));
        const double step = height_m / voxel_m / scene.output.size_px[1];
        const core::Ray a = camera.ray(3, 5);
        const core::Ray b = camera.ray(4, 5);
        const core::Ray c = camera.ray(3, 6);
        REQUIRE((core::length(a.direction - b.direction) == 0 &&
                 core::length(a.direction - c.direction) == 0));
        REQUIRE(core::length(b.origin - a.origin) == Approx(step).epsilon(1e-6));
        REQUIRE(core::length(c.origin - a.origin) == Approx(step).epsilon(1e-6));
        REQUIRE(std::abs(core::dot(b.origin - a.origin, c.origin - a.origin)) <
                1e-6 * step * step + 1e-7);
        REQUIRE(camera.pixel_voxels(0) == Approx(step));
        REQUIRE(camera.pixel_voxels(1e5) == Approx(step));
        for (int i = 0; i < 8; ++i) {
            REQUIRE(core::dot(corner(kWorldBounds, i) - a.origin, a.direction) >
                    32);  // the coarsest voxel's edge
        }
    }
}

TEST_CASE("an isometric camera sees the three edges of a cube equally long, 120 degrees apart",
          "[raytracer][camera][orthographic]") {
    scene::Scene scene = make_scene(core::CameraProjection::kIsometric);
    scene.camera.azimuth_deg = GENERATE(45.0, 135.0, 225.0, -45.0);
    const scene::Camera camera = scene::make_camera(scene, {}, {{0, 0, 0}, {64, 64, 64}});
    CHECK(std::asin(-camera.forward().y) * 180 / kPi == Approx(35.264389682754654));
    for (const core::Vec3 edge : {core::Vec3{1, 0, 0}, core::Vec3{0, 1, 0}, core::Vec3{0, 0, 1}})
        CHECK(core::length(edge - camera.forward() * core::dot(edge, camera.forward())) ==
              Approx(std::sqrt(2.0 / 3)));
}

TEST_CASE(
    "framing cameras of parallel rays and fisheyes see all corners of the world, within the margin",
    "[raytracer][camera]") {
    const auto projection =
        GENERATE(core::CameraProjection::kOrthographic, core::CameraProjection::kIsometric,
                 core::CameraProjection::kFisheye);
    Random random(5);
    for (int run = 0; run < 200; ++run) {
        scene::Scene scene = make_scene(projection, 1 + static_cast<int>(random.in(0, 900)),
                                        1 + static_cast<int>(random.in(0, 900)));
        scene.camera.azimuth_deg = random.in(-360, 360);
        scene.camera.down_deg = random.in(-30, 90);
        scene.camera.roll_deg = random.in(-90, 90);
        scene.camera.fov_deg = random.in(1, 360);
        scene.camera.margin = random.in(0, 0.4);
        const scene::Camera camera = scene::make_camera(scene, {}, kWorldBounds);
        const double w = scene.output.size_px[0];
        const double h = scene.output.size_px[1];
        double most = 0;
        for (int i = 0; i < 8; ++i) {
            const core::Vec3 to = corner(kWorldBounds, i) - camera.position();
            if (projection == core::CameraProjection::kFisheye) {
                most =
                    std::max(most, angle_between(to, camera.forward()) / camera.half_angle_rad());
                continue;
            }
            const core::Vec3 right = camera.ray(w, h / 2).origin - camera.position();
            const core::Vec3 up = camera.ray(w / 2, 0).origin - camera.position();
            most = std::max({most, std::abs(core::dot(to, right)) / core::dot(right, right),
                             std::abs(core::dot(to, up)) / core::dot(up, up)});
        }
        INFO(projection << " run " << run << ", " << w << " x " << h << ": " << most
                        << " of the picture, margin " << scene.camera.margin << ", fov "
                        << scene.camera.fov_deg);
        REQUIRE(most <= 1 - 2 * scene.camera.margin + 1e-9);
        if (projection != core::CameraProjection::kFisheye)
            REQUIRE(most >= 1 - 2 * scene.camera.margin - 1e-9);
    }
    scene::Scene scene = make_scene(projection);
    const auto size = [&](double zoom) {
        scene.camera.zoom = zoom;
        const scene::Camera camera = scene::make_camera(scene, {}, kWorldBounds);
        return projection == core::CameraProjection::kFisheye
                   ? core::dot(core::Vec3{450, 120, 420} - camera.position(), camera.forward())
                   : camera.pixel_voxels(0);
    };
    CHECK(size(2) == Approx(size(1) / 2));
}

TEST_CASE("a panorama that frames the world stands above its middle",
          "[raytracer][camera][panorama]") {
    const scene::Camera camera =
        scene::make_camera(make_scene(core::CameraProjection::kPanorama), {}, kWorldBounds);
    CHECK((camera.position().x == 450 && camera.position().z == 420 && camera.position().y > 250));
}

TEST_CASE("a camera that cannot be is refused in one line that names field, value and range",
          "[raytracer][camera]") {
    struct Case {
        const char* name;
        core::CameraProjection projection;
        void (*change)(scene::Scene::Camera&);
        std::string said;
    };
    const auto c = GENERATE(values<Case>({
        {"no field of view", core::CameraProjection::kPerspective,
         [](scene::Scene::Camera& s) { s.fov_deg = 0; },
         "camera.fov_deg = 0; allowed for a perspective: 1 to 170"},
        {"a field of view that is no number", core::CameraProjection::kPerspective,
         [](scene::Scene::Camera& s) { s.fov_deg = kNan; }, "camera.fov_deg = nan"},
        {"more than all around", core::CameraProjection::kFisheye,
         [](scene::Scene::Camera& s) { s.fov_deg = 361; }, "allowed for a fisheye: 1 to 360"},
        {"a position that is no number", core::CameraProjection::kPerspective,
         [](scene::Scene::Camera& s) { s.position = {kNan, 0, 0}; },
         "camera.position = (nan, 0, 0); allowed: finite numbers"},
        {"a position far out", core::CameraProjection::kPerspective,
         [](scene::Scene::Camera& s) { s.position = {1.5e9, 0, 0}; },
         "camera.position = (1500000000, 0, 0) lies beyond 10^9 voxels"},
        {"the same point twice", core::CameraProjection::kPanorama,
         [](scene::Scene::Camera& s) { s.target = s.position; }, "are the same point"},
        {"a position alone", core::CameraProjection::kOrthographic,
         [](scene::Scene::Camera& s) { s.target.reset(); }, "camera.target is missing"},
        {"a target alone", core::CameraProjection::kFisheye,
         [](scene::Scene::Camera& s) { s.position.reset(); }, "camera.position is missing"},
        {"a panorama with a lens", core::CameraProjection::kPanorama,
         [](scene::Scene::Camera& s) { s.aperture_m = 1; },
         "camera.aperture_m = 1; allowed for a panorama: 0"},
        {"a fisheye with a lens", core::CameraProjection::kFisheye,
         [](scene::Scene::Camera& s) { s.aperture_m = 0.5; },
         "camera.aperture_m = 0.5; allowed for a fisheye: 0"},
        {"a panorama on its side", core::CameraProjection::kPanorama,
         [](scene::Scene::Camera& s) { s.roll_deg = 90; },
         "camera.roll_deg = 90; allowed for a panorama: 0"},
        {"a negative lens", core::CameraProjection::kPerspective,
         [](scene::Scene::Camera& s) { s.aperture_m = -1; }, "camera.aperture_m = -1"},
        {"sharp at nothing", core::CameraProjection::kPerspective,
         [](scene::Scene::Camera& s) { s.focus_m = 0; }, "camera.focus_m = 0; allowed: 0.001 to"},
        {"no height", core::CameraProjection::kOrthographic,
         [](scene::Scene::Camera& s) { s.height_m = 0; }, "camera.height_m = 0"},
        {"endless roll", core::CameraProjection::kPerspective,
         [](scene::Scene::Camera& s) { s.roll_deg = kInf; }, "camera.roll_deg = inf"},
        {"no zoom", core::CameraProjection::kOrthographic,
         [](scene::Scene::Camera& s) { s.zoom = 0; }, "camera.zoom = 0"},
    }));
    DYNAMIC_SECTION(c.name) {
        scene::Scene scene = make_scene(c.projection);
        scene.camera.space = core::CoordinateSpace::kVoxel;
        scene.camera.position = {0, 100, 0};
        scene.camera.target = {30, 60, -40};
        c.change(scene.camera);
        std::string said;
        try {
            (void)scene::make_camera(scene, slovenia(), kWorldBounds);
        } catch (const util::UsageError& e) {
            said = e.what();
        }
        CHECK_THAT(said, contains("place the camera: ") && contains(c.said));
        CHECK(said.find('\n') == std::string::npos);
    }
}

TEST_CASE("cameras that look straight up or down, and other odd but right ones, have finite rays",
          "[raytracer][camera]") {
    const auto projection =
        GENERATE(core::CameraProjection::kPerspective, core::CameraProjection::kOrthographic,
                 core::CameraProjection::kIsometric, core::CameraProjection::kPanorama,
                 core::CameraProjection::kFisheye);
    const auto target = GENERATE(values<std::array<double, 3>>({{10, 600, 20},
                                                                {10, -600, 20},
                                                                {10 + 1e-7, -600, 20},
                                                                {10.001, -600, 20},
                                                                {9e8, 100, -9e8},
                                                                {10, 100 + 1e-6, 20}}));
    const auto size = GENERATE(values<std::array<int, 2>>({{1, 1}, {65536, 1}, {1, 65536}}));
    scene::Scene scene = make_scene(projection, size[0], size[1]);
    scene.camera.space = core::CoordinateSpace::kVoxel;
    scene.camera.position = {10, 100, 20};
    scene.camera.target = target;
    const scene::Camera camera = scene::make_camera(scene, slovenia(), kWorldBounds);
    for (const double x : {0.0, 0.5, size[0] / 2.0, size[0] - 0.25})
        for (const double y : {0.0, 0.5, size[1] / 2.0, size[1] - 0.25}) {
            const core::Ray ray = camera.ray(x, y);
            INFO(projection << ", target " << target[0] << " " << target[1] << " " << target[2]
                            << ": " << to_text(ray.direction) << " from " << to_text(ray.origin));
            CHECK(core::length(ray.direction) == Approx(1).epsilon(1e-12));
            CHECK(std::isfinite(core::length(ray.origin)));
        }
}
