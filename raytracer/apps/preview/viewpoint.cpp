#include "raytracer/apps/preview/viewpoint.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace terravox::preview {
namespace {

constexpr double kRad = std::numbers::pi / 180;
constexpr double kSteepest_deg = 89.9;  // straight down has no heading

core::Vec3 to_direction(double heading_deg, double down_deg) {
    const double h = heading_deg * kRad;
    const double d = down_deg * kRad;
    return {std::sin(h) * std::cos(d), -std::sin(d), -std::cos(h) * std::cos(d)};
}

double to_millimetres(double v) {
    return std::round(v * 1000) / 1000;
}

}  // namespace

Viewpoint Viewpoint::of(const scene::Camera& camera, double ground_y) {
    constexpr double kLevel = 0.01;
    constexpr double kAhead = 500;
    const core::Vec3 p = camera.position();
    const core::Vec3 f = camera.forward();
    const double reach = f.y < -kLevel ? (ground_y - p.y) / f.y : kAhead;
    return {p, p + f * std::clamp(reach, kNearest, kFarthest)};
}

void Viewpoint::apply(scene::Scene& scene, const voxel::WorldInfo& world) const {
    const bool on_earth = !world.crs.empty();
    const auto place = [&](core::Vec3 v) -> std::array<double, 3> {
        if (!on_earth)
            return {to_millimetres(v.x), to_millimetres(v.y), to_millimetres(v.z)};
        return {to_millimetres(v.x * world.crs_units_per_voxel),
                to_millimetres(-v.z * world.crs_units_per_voxel),
                to_millimetres(v.y * world.voxel_m)};
    };
    scene.camera.space = on_earth ? core::CoordinateSpace::kCrs : core::CoordinateSpace::kVoxel;
    scene.camera.position = place(position);
    scene.camera.target = place(target);
    // An isometric camera keeps its slope, and turns by its own field.
    scene.camera.azimuth_deg = std::remainder(std::round(heading_deg() * 1000) / 1000 + 180, 360);
}

double Viewpoint::heading_deg() const noexcept {
    const core::Vec3 f = target - position;
    const double deg = std::atan2(f.x, -f.z) / kRad;
    return deg < 0 ? deg + 360 : deg;
}

double Viewpoint::down_deg() const noexcept {
    return std::asin(std::clamp((position.y - target.y) / distance(), -1.0, 1.0)) / kRad;
}

void Viewpoint::set_direction(double heading, double down, bool target_stays) noexcept {
    const core::Vec3 way =
        to_direction(heading, std::clamp(down, -kSteepest_deg, kSteepest_deg)) * distance();
    if (target_stays)
        position = target - way;
    else
        target = position + way;
}

void Viewpoint::look(double right_deg, double down) noexcept {
    set_direction(heading_deg() + right_deg, down_deg() + down, false);
}

void Viewpoint::walk(double right, double up, double forward) noexcept {
    const double h = heading_deg() * kRad;
    const core::Vec3 way = core::Vec3{std::cos(h), 0, std::sin(h)} * right + core::Vec3{0, up, 0} +
                           core::Vec3{std::sin(h), 0, -std::cos(h)} * forward;
    position = position + way;
    target = target + way;
}

void Viewpoint::fly(double right, double up, double forward) noexcept {
    const scene::Axes axes = scene::make_axes(core::normalized(target - position));
    const core::Vec3 way = axes.right * right + core::Vec3{0, up, 0} + axes.forward * forward;
    position = position + way;
    target = target + way;
}

void Viewpoint::approach(double factor) noexcept {
    const double was = distance();
    position = target - (target - position) * (std::clamp(was * factor, kNearest, kFarthest) / was);
}

void Viewpoint::go_to(core::Vec3 point) noexcept {
    position = position + (point - target);
    target = point;
}

void Viewpoint::face(core::Vec3 point) noexcept {
    const double reach = core::length(point - position);
    if (!(reach >= kNearest))
        return;
    target = point;
    set_direction(heading_deg(), down_deg(), false);
}

std::optional<std::array<double, 2>> find_pixel(const scene::Camera& camera, core::Vec3 point,
                                                int width_px, int height_px) noexcept {
    const auto to_ndc = camera.world_to_ndc();
    if (!to_ndc)
        return std::nullopt;
    const auto& m = *to_ndc;
    const auto origin = camera.picture_origin();
    const double metres = camera.voxel_m();
    const std::array<double, 4> v{(point.x - static_cast<double>(origin[0])) * metres,
                                  (point.y - static_cast<double>(origin[1])) * metres,
                                  (point.z - static_cast<double>(origin[2])) * metres, 1};
    std::array<double, 4> out{};
    for (std::size_t column = 0; column < 4; ++column)
        for (std::size_t row = 0; row < 4; ++row)
            out[column] += v[row] * m[row * 4 + column];
    if (core::dot(point - camera.position(), camera.forward()) <= 0 &&
        camera.projection() == scene::Projection::kPerspective)
        return std::nullopt;
    if (!(std::abs(out[3]) > 1e-12))
        return std::nullopt;
    return std::array{out[0] / out[3] * width_px, out[1] / out[3] * height_px};
}

}  // namespace terravox::preview
