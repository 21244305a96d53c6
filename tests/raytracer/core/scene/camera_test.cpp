#include "raytracer/core/scene/camera.hpp"

#include <cmath>
#include <numbers>

#include "common/geo/crs.hpp"
#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/raytracer/core/scene/some_cameras.hpp"

using namespace terravox;
using terravox::test::contains;
using terravox::test::corner;
using voxel::VoxelBounds;

namespace {

/// Where a point lands in the picture, px right and down, from the camera's own rays; z: distance
/// along its axis.
struct Pixel {
    double x;
    double y;
    double depth;
};
Pixel find_pixel(const scene::Camera& camera, core::Vec3 point, int width, int height) {
    // The picture's axes out of three rays: the middle one, and the rates of change to the right
    // and down.
    const auto flat = [&](double px, double py) {
        const core::Vec3 d = camera.ray(px, py).direction;
        return d * (1 / core::dot(d, camera.forward()));
    };
    const core::Vec3 middle = flat(width / 2.0, height / 2.0);
    const core::Vec3 right = flat(width, height / 2.0) - middle;
    const core::Vec3 down = flat(width / 2.0, height) - middle;
    const core::Vec3 to = point - camera.position();
    const double depth = core::dot(to, camera.forward());
    return {width / 2.0 * (1 + core::dot(to, right) / depth / core::dot(right, right)),
            height / 2.0 * (1 + core::dot(to, down) / depth / core::dot(down, down)), depth};
}

voxel::WorldInfo delft() {
    voxel::WorldInfo world;
    const auto crs = geo::Crs::from_text("EPSG:28992");
    world.crs = crs.name();
    world.crs_wkt = crs.wkt();
    world.voxel_m = 0.5;
    world.crs_units_per_voxel = 0.5;
    return world;
}

constexpr VoxelBounds kSubjects[] = {{{0, 0, 0}, {1, 1, 1}},
                                     {{-300, -10, 40}, {1200, 250, 800}},
                                     {{461'900, 480, -101'100}, {462'100, 900, -100'900}},
                                     {{0, 0, 0}, {2000, 3, 7}}};

}  // namespace

TEST_CASE(
    "the framing camera sees all eight corners of the world, within its margin, and wastes no room",
    "[raytracer][camera]") {
    const std::size_t subject = GENERATE(0u, 1u, 2u, 3u);
    const double down = GENERATE(-30.0, 0.0, 35.0, 60.0, 89.0, 90.0);
    const double fov = GENERATE(1.0, 40.0, 120.0, 160.0);
    const auto size =
        GENERATE(values<std::array<int, 2>>({{1280, 720}, {300, 900}, {1, 1}, {4000, 10}}));
    const double margin = GENERATE(0.0, 0.04, 0.45);
    scene::Scene scene;
    scene.camera.down_deg = down;
    scene.camera.fov_deg = fov;
    scene.camera.margin = margin;
    scene.output.size_px = size;
    const VoxelBounds& b = kSubjects[subject];
    for (const double azimuth : {0.0, 33.0, 90.0, 225.0, -360.0}) {
        scene.camera.azimuth_deg = azimuth;
        const scene::Camera camera = scene::make_camera(scene, {}, b);
        double low_x = 1e9;
        double high_x = -1e9;
        double low_y = 1e9;
        double high_y = -1e9;
        double nearest = 1e18;
        for (int i = 0; i < 8; ++i) {
            const Pixel p = find_pixel(camera, corner(b, i), size[0], size[1]);
            low_x = std::min(low_x, p.x / size[0]);
            high_x = std::max(high_x, p.x / size[0]);
            low_y = std::min(low_y, p.y / size[1]);
            high_y = std::max(high_y, p.y / size[1]);
            nearest = std::min(nearest, p.depth);
        }
        INFO("subject " << subject << ", azimuth " << azimuth << ", down " << down << ", fov "
                        << fov << ", " << size[0] << "x" << size[1] << ", margin " << margin
                        << ": x " << low_x << " to " << high_x << ", y " << low_y << " to "
                        << high_y << ", nearest " << nearest);
        constexpr double kSlack = 1e-6;
        CHECK(nearest > 0);
        CHECK(low_x >= margin - kSlack);
        CHECK(high_x <= 1 - margin + kSlack);
        CHECK(low_y >= margin - kSlack);
        CHECK(high_y <= 1 - margin + kSlack);
        // One pair of sides touches, unless the camera would stand in the world.
        const bool touches =
            high_x - low_x > 1 - 2 * margin - 1e-4 || high_y - low_y > 1 - 2 * margin - 1e-4;
        CHECK((touches || nearest < 1.0001));
    }
}

TEST_CASE("the framing camera is at its azimuth and looks across", "[raytracer][camera]") {
    struct Case {
        const char* name;
        double azimuth;
        core::Vec3 from;
    };
    const auto c = GENERATE(values<Case>({{"north", 0, {0, 0, -1}},
                                          {"east", 90, {1, 0, 0}},
                                          {"south", 180, {0, 0, 1}},
                                          {"west", 270, {-1, 0, 0}}}));
    DYNAMIC_SECTION(c.name) {
        scene::Scene scene;
        scene.camera.azimuth_deg = c.azimuth;
        scene.camera.down_deg = 0;
        const VoxelBounds b{{-10, -10, -10}, {10, 10, 10}};
        const scene::Camera camera = scene::make_camera(scene, {}, b);
        CHECK(core::dot(camera.position(), c.from) > 10);
        CHECK(core::length(camera.forward() + c.from) < 1e-12);
        // Up is up: the ray above the middle climbs.
        CHECK(camera.ray(640, 0).direction.y > 0);
        CHECK(camera.ray(640, 720).direction.y < 0);
    }
}

TEST_CASE("straight down, north is up and east is right", "[raytracer][camera]") {
    scene::Scene scene;
    scene.camera.down_deg = 90;
    const scene::Camera camera = scene::make_camera(scene, {}, {{0, 0, 0}, {100, 10, 100}});
    CHECK(camera.ray(640, 0).direction.z < -0.05);
    CHECK(camera.ray(1280, 360).direction.x > 0.05);
}

TEST_CASE("parallel rays start above what stands out of typical heights", "[raytracer][camera]") {
    voxel::WorldInfo world;
    world.bounds = {{0, 0, 0}, {100, 800, 100}};
    world.typical_heights = voxel::HeightRange{0, 40};
    scene::Scene scene;
    scene.camera.projection = core::CameraProjection::kOrthographic;
    const double down = GENERATE(20.0, 90.0);
    scene.camera.down_deg = down;
    const scene::Camera camera = scene::make_camera(scene, world, world.camera_bounds());
    const scene::Camera low = scene::make_camera(scene, {}, world.camera_bounds());
    CHECK(camera.pixel_voxels(0) == low.pixel_voxels(0));
    for (int i = 0; i < 8; ++i)
        CHECK(core::dot(corner(world.bounds, i) - camera.position(), camera.forward()) > 0);
}

TEST_CASE("zoom brings the camera nearer along its line of sight", "[raytracer][camera]") {
    scene::Scene scene;
    const VoxelBounds b{{0, 0, 0}, {100, 20, 100}};
    const core::Vec3 middle{50, 10, 50};
    const auto distance = [&](double zoom) {
        scene.camera.zoom = zoom;
        return core::dot(middle - scene::make_camera(scene, {}, b).position(),
                         scene::make_camera(scene, {}, b).forward());
    };
    CHECK(distance(2) == Approx(distance(1) / 2));
    CHECK(distance(0.5) == Approx(distance(1) * 2));
}

TEST_CASE(
    "a camera is the same whether its place is given in CRS, latitude and longitude, or voxels",
    "[raytracer][camera]") {
    const voxel::WorldInfo world = delft();
    const std::array<double, 3> position{84'500.25, 447'350.5, 60};
    const std::array<double, 3> target{84'600, 447'400, 1.5};
    scene::Scene scene;
    scene.camera.position = position;
    scene.camera.target = target;
    const scene::Camera by_crs = scene::make_camera(scene, world, {});
    CHECK(by_crs.position().x == Approx(169'000.5).epsilon(1e-12));
    CHECK(by_crs.position().y == 120);
    CHECK(by_crs.position().z == Approx(-894'701).epsilon(1e-12));

    scene.camera.space = core::CoordinateSpace::kVoxel;
    const auto voxels = [](core::Vec3 v) { return std::array<double, 3>{v.x, v.y, v.z}; };
    scene.camera.position = voxels(scene::to_voxels(position, core::CoordinateSpace::kCrs, world));
    scene.camera.target = voxels(scene::to_voxels(target, core::CoordinateSpace::kCrs, world));
    const scene::Camera by_voxel = scene::make_camera(scene, world, {});
    CHECK(core::length(by_voxel.position() - by_crs.position()) == 0);
    CHECK(core::length(by_voxel.forward() - by_crs.forward()) == 0);

    scene.camera.space = core::CoordinateSpace::kLatLon;
    const auto latlon = [&](const std::array<double, 3>& p) {
        const auto at = geo::to_lat_lon(geo::Crs::from_text("EPSG:28992"), p[0], p[1]);
        return std::array<double, 3>{at.lat_deg, at.lon_deg, p[2]};
    };
    scene.camera.position = latlon(position);
    scene.camera.target = latlon(target);
    const scene::Camera by_place = scene::make_camera(scene, world, {});
    // A centimetre: what the way there and back through the datum costs.
    CHECK(core::length(by_place.position() - by_crs.position()) * world.voxel_m < 0.01);
}

TEST_CASE("a camera that cannot be placed is refused, naming the field", "[raytracer][camera]") {
    const voxel::WorldInfo nowhere;
    const VoxelBounds b{{0, 0, 0}, {9, 9, 9}};
    scene::Scene scene;
    SECTION("a place on Earth in a world that has none") {
        scene.camera.position = {1, 2, 3};
        scene.camera.target = {4, 5, 6};
        scene.camera.space = GENERATE(core::CoordinateSpace::kCrs, core::CoordinateSpace::kLatLon);
        CHECK_THROWS_AS(scene::make_camera(scene, nowhere, b), util::UsageError);
        CHECK_THROWS_WITH(scene::make_camera(scene, nowhere, b),
                          contains("not georeferenced") && contains("allowed: voxel"));
        scene.camera.space = core::CoordinateSpace::kVoxel;
        CHECK_NOTHROW(scene::make_camera(scene, nowhere, b));
    }
    SECTION("a latitude beyond the pole") {
        scene.camera.position = {91, 4, 3};
        scene.camera.target = {52, 4, 6};
        scene.camera.space = core::CoordinateSpace::kLatLon;
        CHECK_THROWS_AS(scene::make_camera(scene, delft(), b), util::Error);
    }
}
