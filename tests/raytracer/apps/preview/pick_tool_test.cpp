#include "raytracer/apps/preview/pick_tool.hpp"

#include <cmath>
#include <numbers>

#include "tests/catch.hpp"
#include "tests/raytracer/landscape.hpp"

using namespace terravox;

TEST_CASE("the ray through a place in the window is that of the picture's pixel", "[preview]") {
    scene::Scene scene = test::small_scene();
    scene.output.size_px = {400, 200};
    const test::Job job(scene);
    const scene::Camera& camera = job.view.camera;
    const preview::Pane pane{100, 50, 200, 100};
    struct Case {
        const char* name;
        double x, y;    ///< in the window
        double px, py;  ///< in the picture
        bool is_in = true;
    };
    const auto c = GENERATE(values<Case>({
        {"the middle", 200, 100, 200, 100},
        {"the upper left corner", 100, 50, 0, 0},
        {"a place in the lower right quarter", 275, 120, 350, 140},
        {"right of the pane", 300, 100, 0, 0, false},
        {"above the pane", 200, 49, 0, 0, false},
    }));
    DYNAMIC_SECTION(c.name) {
        const auto ray = preview::ray_through(camera, scene.output.size_px, pane, c.x, c.y);
        REQUIRE(ray.has_value() == c.is_in);
        if (!ray)
            return;
        const auto wanted = camera.ray(c.px, c.py, 0.5, 0.5);
        REQUIRE(wanted);
        CHECK(ray->origin == wanted->origin);
        CHECK(ray->direction == wanted->direction);
    }
}

TEST_CASE("a distance is measured on the map, in height, and through the air", "[preview]") {
    preview::Picked from;
    preview::Picked to;
    from.point = {10, 5, 20};
    to.point = {40, 15, -20};
    const preview::Measured m = preview::measure(from, to, 0.5);
    CHECK(m.level_m == Approx(25));
    CHECK(m.height_m == Approx(5));
    CHECK(m.length_m == Approx(std::sqrt(25.0 * 25 + 5 * 5)));
    CHECK(m.heading_deg == Approx(std::atan2(30, 40) * 180 / std::numbers::pi));
    CHECK(preview::measure(to, from, 0.5).heading_deg == Approx(m.heading_deg + 180));
}
