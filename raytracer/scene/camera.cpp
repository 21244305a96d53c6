#include "raytracer/scene/camera.hpp"

#include <algorithm>
#include <numbers>
#include <string>

#include "common/util/error.hpp"

namespace terravox {
namespace {

constexpr double kRad = std::numbers::pi / 180;

struct Axes {
    Vec3 forward, right, up;
};

Axes axes_of(Vec3 forward) {
    // Straight down or up: north is up in the picture.
    const Vec3 pole = std::abs(forward.y) > 0.99999 ? Vec3{0, 0, -1} : Vec3{0, 1, 0};
    const Vec3 right = normalized(cross(forward, pole));
    return {forward, right, cross(right, forward)};
}

/// The camera on a given line of sight that sees all eight corners of a block, as near as possible.
/// In camera axes each side of the picture is a plane through the camera; the corner that is farthest out fixes it. The pair of
/// left and right planes gives one distance, top and bottom another; the farther one frames both.
Vec3 frame_position(const voxel::VoxelBounds& b, const Axes& axes, double tan_x, double tan_y) {
    constexpr double kBig = 1e30;
    double low_x = kBig, high_x = -kBig, low_y = kBig, high_y = -kBig, nearest = kBig;
    const Vec3 middle{(b.min[0] + b.max[0]) / 2.0, (b.min[1] + b.max[1]) / 2.0, (b.min[2] + b.max[2]) / 2.0};
    for (int i = 0; i < 8; ++i) {
        const Vec3 corner = Vec3{static_cast<double>((i & 1) != 0 ? b.max[0] : b.min[0]), static_cast<double>((i & 2) != 0 ? b.max[1] : b.min[1]),
                                 static_cast<double>((i & 4) != 0 ? b.max[2] : b.min[2])} - middle;
        const double d = dot(corner, axes.forward), x = dot(corner, axes.right), y = dot(corner, axes.up);
        // Camera at (cx, cy, -depth): |x - cx| <= tan_x (d + depth).
        low_x = std::min(low_x, x + tan_x * d), high_x = std::max(high_x, x - tan_x * d);
        low_y = std::min(low_y, y + tan_y * d), high_y = std::max(high_y, y - tan_y * d);
        nearest = std::min(nearest, d);
    }
    const double depth = std::max({(high_x - low_x) / (2 * tan_x), (high_y - low_y) / (2 * tan_y), 1 - nearest});
    return middle + axes.right * ((high_x + low_x) / 2) + axes.up * ((high_y + low_y) / 2) - axes.forward * depth;
}

}  // namespace

Camera::Camera(Vec3 position, Vec3 target, double fov_deg, int width_px, int height_px) : m_position(position), m_width(width_px), m_height(height_px) {
    const Axes axes = axes_of(normalized(target - position));
    const double half = std::tan(fov_deg * kRad / 2);
    m_forward = axes.forward, m_right = axes.right * half, m_up = axes.up * half;
}

Ray Camera::ray(double px, double py) const noexcept {
    const double u = (2 * px - m_width) / m_height, v = (m_height - 2 * py) / m_height;
    return {m_position, normalized(m_forward + m_right * u + m_up * v)};
}

Vec3 to_voxels(const std::array<double, 3>& p, const std::string& space, const voxel::WorldInfo& world) {
    if (space == "voxel") return {p[0], p[1], p[2]};
    if (world.crs.empty()) throw UsageError("place the camera: camera.space = '" + space + "', but this world has no place on Earth; allowed: voxel");
    double easting = p[0], northing = p[1];
    if (space == "latlon") {
        easting = p[1], northing = p[0];
        geo::Transform(geo::Crs::from_text("EPSG:4326"), geo::Crs::from_text(world.crs_wkt)).apply({&easting, 1}, {&northing, 1});
    }
    return {easting / world.crs_units_per_voxel, p[2] / world.voxel_m, -northing / world.crs_units_per_voxel};
}

Camera make_camera(const Scene& scene, const voxel::WorldInfo& world, const voxel::VoxelBounds& subject) {
    const Scene::Camera& c = scene.camera;
    const auto [width, height] = scene.output.size_px;
    if (c.position.has_value() != c.target.has_value())
        throw UsageError(std::string("place the camera: camera.") + (c.position ? "target" : "position") + " is missing; give both, or none to frame the world");
    if (c.position) {
        const Vec3 position = to_voxels(*c.position, c.space, world), target = to_voxels(*c.target, c.space, world);
        if (!(length(target - position) > 1e-9)) throw UsageError("place the camera: camera.position and camera.target are the same point");
        return {position, target, c.fov_deg, width, height};
    }
    const double azimuth = c.azimuth_deg * kRad, down = c.down_deg * kRad;
    // The camera stands at the azimuth, so it looks the other way. North is -z.
    const Vec3 forward{-std::sin(azimuth) * std::cos(down), -std::sin(down), std::cos(azimuth) * std::cos(down)};
    const double tan_y = std::tan(c.fov_deg * kRad / 2) * (1 - 2 * c.margin);
    const Axes axes = axes_of(forward);
    Vec3 position = frame_position(subject, axes, tan_y * width / height, tan_y);
    const Vec3 middle{(subject.min[0] + subject.max[0]) / 2.0, (subject.min[1] + subject.max[1]) / 2.0, (subject.min[2] + subject.max[2]) / 2.0};
    position = position + forward * (dot(middle - position, forward) * (1 - 1 / c.zoom));
    return {position, position + forward, c.fov_deg, width, height};
}

}  // namespace terravox
