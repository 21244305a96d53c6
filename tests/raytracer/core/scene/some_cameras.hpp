#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <random>
#include <string>

#include "common/geo/crs.hpp"
#include "raytracer/core/scene/camera.hpp"

namespace terravox::test {

inline constexpr double kPi = std::numbers::pi;
inline constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
inline constexpr double kInf = std::numeric_limits<double>::infinity();
inline const voxel::VoxelBounds kWorldBounds{{-300, -10, 40}, {1200, 250, 800}};

inline voxel::WorldInfo slovenia(double voxel_m = 1) {
    voxel::WorldInfo world;
    const auto crs = geo::Crs::from_text("EPSG:3794");
    world.crs = crs.name();
    world.crs_wkt = crs.wkt();
    world.bounds = kWorldBounds;
    world.voxel_m = world.crs_units_per_voxel = voxel_m;
    world.levels = 6;
    return world;
}

class Random {
public:
    explicit Random(std::uint64_t seed) : m_engine(seed) {}
    double in(double low, double high) {
        return low + (high - low) * (static_cast<double>(m_engine() >> 11) * 0x1p-53);
    }

private:
    std::mt19937_64 m_engine;
};

inline scene::Scene make_scene(core::CameraProjection projection, int width = 640,
                               int height = 360) {
    scene::Scene scene;
    scene.camera.projection = projection;
    scene.output.size_px = {width, height};
    return scene;
}

inline core::Vec3 corner(const voxel::VoxelBounds& b, int i) {
    return {static_cast<double>((i & 1) != 0 ? b.max[0] : b.min[0]),
            static_cast<double>((i & 2) != 0 ? b.max[1] : b.min[1]),
            static_cast<double>((i & 4) != 0 ? b.max[2] : b.min[2])};
}

/// A camera somewhere about the world that looks somewhere.
inline scene::Scene placed(Random& random, core::CameraProjection projection) {
    scene::Scene scene = make_scene(projection, 1 + static_cast<int>(random.in(1, 900)),
                                    1 + static_cast<int>(random.in(1, 900)));
    scene.camera.space = core::CoordinateSpace::kVoxel;
    const auto point = [&] {
        return std::array<double, 3>{random.in(-900, 1900), random.in(-300, 900),
                                     random.in(-500, 1500)};
    };
    scene.camera.position = point();
    scene.camera.target = point();
    scene.camera.fov_deg = random.in(2, projection == core::CameraProjection::kFisheye ? 360 : 150);
    if (projection != core::CameraProjection::kPanorama)
        scene.camera.roll_deg = random.in(-360, 360);
    return scene;
}

inline std::string to_text(core::Vec3 v) {
    return "(" + std::to_string(v.x) + ", " + std::to_string(v.y) + ", " + std::to_string(v.z) +
           ")";
}

inline double angle_between(core::Vec3 a, core::Vec3 b) {
    return std::atan2(core::length(core::cross(a, b)), core::dot(a, b));
}

}  // namespace terravox::test
