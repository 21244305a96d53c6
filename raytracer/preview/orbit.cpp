#include "raytracer/preview/orbit.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace terravox {
namespace {

constexpr double kRad = std::numbers::pi / 180;

Vec3 forward_of(double azimuth_deg, double down_deg) {
    const double a = azimuth_deg * kRad, d = down_deg * kRad;
    return {-std::sin(a) * std::cos(d), -std::sin(d), std::cos(a) * std::cos(d)};
}

}  // namespace

Orbit Orbit::from(const Camera& camera, double ground_y) {
    Orbit out;
    const Vec3 p = camera.position(), f = camera.forward();
    const double reach = f.y < -0.01 ? (ground_y - p.y) / f.y : 500;
    out.distance = std::clamp(reach, 2.0, 100000.0);
    out.target = p + f * out.distance;
    out.down_deg = std::asin(std::clamp(-f.y, -1.0, 1.0)) / kRad;
    out.azimuth_deg = std::atan2(-f.x, f.z) / kRad;
    return out;
}

void Orbit::apply(Scene& scene) const {
    const Vec3 p = target - forward_of(azimuth_deg, down_deg) * distance;
    scene.camera.space = "voxel";
    scene.camera.position = {p.x, p.y, p.z};
    scene.camera.target = {target.x, target.y, target.z};
}

void Orbit::pan(double right, double forward) noexcept {
    const double a = azimuth_deg * kRad;
    const Vec3 ahead{-std::sin(a), 0, std::cos(a)}, aside{-std::cos(a), 0, -std::sin(a)};
    target = target + (aside * right + ahead * forward) * distance;
}

void Orbit::turn(double azimuth, double down) noexcept {
    azimuth_deg = std::remainder(azimuth_deg + azimuth, 360);
    down_deg = std::clamp(down_deg + down, -10.0, 89.0);
}

void Orbit::zoom(double factor) noexcept { distance = std::clamp(distance * factor, 2.0, 200000.0); }

}  // namespace terravox
