#include "raytracer/apps/preview/viewpoint.hpp"

#include <cmath>

#include "raytracer/apps/preview/layers.hpp"
#include "raytracer/apps/preview/pane.hpp"
#include "tests/catch.hpp"

using namespace terravox;

namespace {

voxel::WorldInfo world(const std::string& crs = "") {
    voxel::WorldInfo out;
    out.bounds = {{0, 0, 0}, {100, 50, 100}};
    out.crs = crs;
    out.voxel_m = 0.5;
    out.crs_units_per_voxel = 0.5;
    return out;
}

}  // namespace

TEST_CASE("circling keeps the target and the distance; turning the head keeps the place",
          "[preview]") {
    const double right = GENERATE(0.0, 30.0, -170.0, 720.0);
    const double up = GENERATE(0.0, 20.0, -400.0, 400.0);
    const preview::Viewpoint start{{10, 60, 10}, {40, 5, -20}};
    preview::Viewpoint v = start;
    v.orbit(right, up);
    CHECK(v.target == start.target);
    CHECK(v.distance() == Approx(start.distance()));
    CHECK(std::abs(v.down_deg()) <= 90);
    v = start;
    v.look(right, up);
    CHECK(v.position == start.position);
    CHECK(v.distance() == Approx(start.distance()));
    if (right == 30 && up == 20) {
        CHECK(v.heading_deg() == Approx(start.heading_deg() + 30));
        CHECK(v.down_deg() == Approx(start.down_deg() + 20));
    }
}

TEST_CASE("steps move in their direction", "[preview]") {
    preview::Viewpoint v{{0, 10, 0}, {0, 0, -10}};  // to the north, 45 degrees down
    SECTION("walking stays level") {
        v.walk(1, 2, 3);
        CHECK(v.position.x == Approx(1));
        CHECK(v.position.y == Approx(12));
        CHECK(v.position.z == Approx(-3));
    }
    SECTION("flying goes along the line of sight") {
        v.fly(0, 0, std::sqrt(2.0));
        CHECK(v.position.y == Approx(9));
        CHECK(v.position.z == Approx(-1));
    }
    SECTION("nearer, to a limit") {
        v.approach(0.5);
        CHECK(v.distance() == Approx(std::sqrt(200.0) / 2));
        v.approach(1e-9);
        CHECK(v.distance() == Approx(preview::Viewpoint::kNearest));
    }
    SECTION("going to a place takes the person along") {
        v.go_to({50, 0, 40});
        CHECK(v.target == core::Vec3{50, 0, 40});
        CHECK(v.position == core::Vec3{50, 10, 50});
    }
    SECTION("what is faced is in the middle") {
        v.face({5, 3, -20});
        CHECK(v.position == core::Vec3{0, 10, 0});
        CHECK(core::length(v.target - core::Vec3{5, 3, -20}) < 1e-6);
    }
}

TEST_CASE("a scene has the viewpoint in the world's own coordinates", "[preview]") {
    scene::Scene scene;
    const preview::Viewpoint v{{10, 60, -20}, {40, 5, -90}};
    SECTION("of a CRS") {
        v.apply(scene, world("EPSG:3794"));
        CHECK(scene.camera.space == core::CoordinateSpace::kCrs);
        CHECK(*scene.camera.position == std::array<double, 3>{5, 10, 30});
        CHECK(*scene.camera.target == std::array<double, 3>{20, 45, 2.5});
    }
    SECTION("of none") {
        v.apply(scene, world());
        CHECK(scene.camera.space == core::CoordinateSpace::kVoxel);
        CHECK(*scene.camera.position == std::array<double, 3>{10, 60, -20});
        const preview::Viewpoint back =
            preview::Viewpoint::of(scene::make_camera(scene, world(), world().bounds), 5);
        CHECK(core::length(back.position - v.position) < 1e-3);
        CHECK(core::length(back.target - v.target) < 1e-3);
    }
}

TEST_CASE("a point is shown where a ray through its pixel meets it", "[preview]") {
    const auto projection =
        GENERATE(core::CameraProjection::kPerspective, core::CameraProjection::kOrthographic);
    scene::Scene scene;
    scene.camera.projection = projection;
    scene.camera.space = core::CoordinateSpace::kVoxel;
    scene.camera.position = {{-30, 80, 140}};
    scene.camera.target = {{50, 10, 50}};
    scene.output.size_px = {320, 200};
    const scene::Camera camera = scene::make_camera(scene, world(), world().bounds);
    const core::Ray ray = camera.ray(77.25, 141.5);
    const auto at = preview::find_pixel(camera, ray.origin + ray.direction * 90, 320, 200);
    REQUIRE(at);
    CHECK((*at)[0] == Approx(77.25).margin(0.01));
    CHECK((*at)[1] == Approx(141.5).margin(0.01));
    if (projection == core::CameraProjection::kPerspective)
        CHECK_FALSE(preview::find_pixel(camera, ray.origin - ray.direction * 10, 320, 200));
}

TEST_CASE("the picture has its pane in the middle of what the panel leaves", "[preview]") {
    struct Case {
        const char* name;
        std::array<int, 2> window;
        int panel;
        std::array<int, 2> shape;
        preview::Pane pane;
    };
    const auto& c = GENERATE(
        values<Case>({{"as wide as can be", {1280, 720}, 0, {1920, 1080}, {0, 0, 1280, 720}},
                      {"next to the panel", {1280, 720}, 320, {1920, 1080}, {320, 90, 960, 540}},
                      {"upright", {1000, 600}, 200, {300, 600}, {450, 0, 300, 600}},
                      {"all that is left", {1000, 600}, 200, {0, 0}, {200, 0, 800, 600}},
                      {"a panel as wide as the window", {300, 600}, 400, {16, 9}, {299, 299, 1, 1}},
                      {"a very flat picture", {1000, 601}, 0, {65536, 1}, {0, 300, 1000, 1}},
                      {"a window of one pixel", {1, 1}, 400, {16, 9}, {0, 0, 1, 1}},
                      {"no window", {0, 0}, 0, {16, 9}, {0, 0, 1, 1}}}));
    INFO(c.name);
    const preview::Pane pane = preview::pane_in(c.window, c.panel, c.shape);
    CHECK(pane.x == c.pane.x);
    CHECK(pane.y == c.pane.y);
    CHECK(pane.width == c.pane.width);
    CHECK(pane.height == c.pane.height);
    CHECK(pane.holds(pane.x, pane.y));
    CHECK_FALSE(pane.holds(pane.x + pane.width, pane.y));
}
