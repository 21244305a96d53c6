#include "raytracer/core/scene/camera.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace terravox::scene {

constexpr double kPi = std::numbers::pi;

Axes make_axes(core::Vec3 forward) noexcept {
    // Straight down or up: north is up in the picture.
    const core::Vec3 pole =
        std::abs(forward.y) > 0.99999 ? core::Vec3{0, 0, -1} : core::Vec3{0, 1, 0};
    const core::Vec3 right = core::normalized(core::cross(forward, pole));
    return {forward, right, core::cross(right, forward)};
}

Axes rolled(const Axes& axes, double roll_deg) noexcept {
    if (roll_deg == 0)
        return axes;
    const double c = trig::cos(roll_deg * trig::kRadPerDeg);
    const double s = trig::sin(roll_deg * trig::kRadPerDeg);
    return {axes.forward, axes.right * c - axes.up * s, axes.up * c + axes.right * s};
}

// The C library's tangent, not trig's: pictures from before there were other projections stay the
// same to the last bit.
double half_of_fov(double fov_deg) noexcept {
    return std::tan(fov_deg * trig::kRadPerDeg / 2);
}

Camera::Camera(core::Vec3 position, core::Vec3 target, double fov_deg, int width_px, int height_px)
    : Camera([&] {
          const Axes axes = make_axes(core::normalized(target - position));
          CameraShape shape;
          shape.position = position;
          shape.forward = axes.forward;
          shape.right = axes.right;
          shape.up = axes.up;
          shape.half = half_of_fov(fov_deg);
          shape.width_px = width_px;
          shape.height_px = height_px;
          return shape;
      }()) {}

Camera::Camera(const CameraShape& s)
    : m_position(s.position),
      m_forward(s.forward),
      m_right(s.right),
      m_up(s.up),
      m_width(s.width_px),
      m_height(s.height_px),
      m_projection(s.projection),
      m_half(s.half),
      m_voxel_m(s.voxel_m) {
    switch (m_projection) {
        case Projection::kPerspective:
        case Projection::kOrthographic: {
            m_right = m_right * s.half;
            m_up = m_up * s.half;
            (m_projection == Projection::kPerspective ? m_pixel_rad : m_pixel_voxels) =
                2 * core::length(m_up) / m_height;
            m_lens_radius = s.lens_radius;
            m_focus = s.focus;
            if (m_projection == Projection::kOrthographic)
                m_lens_scale = 1 + s.back / s.focus;
            break;
        }
        case Projection::kPanorama: m_pixel_rad = 2 * kPi / m_width; break;
        case Projection::kFisheye: m_pixel_rad = 2 * s.half / std::min(m_width, m_height); break;
    }
}

bool Camera::sees(double px, double py) const noexcept {
    if (m_projection == Projection::kPanorama)
        return std::abs(m_height - 2 * py) <= m_width / 2;
    if (m_projection != Projection::kFisheye)
        return true;
    const double x = 2 * px - m_width;
    const double y = m_height - 2 * py;
    const double radius = std::min(m_width, m_height);
    return x * x + y * y <= radius * radius;
}

core::Vec3 Camera::panorama_direction(double px, double py) const noexcept {
    const double azimuth = (2 * px - m_width) / m_width * kPi;
    const double altitude = (m_height - 2 * py) / m_width * kPi;
    return (m_forward * trig::cos(azimuth) + m_right * trig::sin(azimuth)) * trig::cos(altitude) +
           m_up * trig::sin(altitude);
}

core::Vec3 Camera::fisheye_direction(double px, double py) const noexcept {
    const double x = 2 * px - m_width;
    const double y = m_height - 2 * py;
    const double r = std::sqrt(x * x + y * y);
    if (r == 0)
        return m_forward;
    const double angle = r / std::min(m_width, m_height) * m_half;
    return m_forward * trig::cos(angle) + (m_right * (x / r) + m_up * (y / r)) * trig::sin(angle);
}

core::Ray Camera::ray(double px, double py) const noexcept {
    switch (m_projection) {
        case Projection::kPerspective:
            return {m_position,
                    core::normalized(m_forward + m_right * across(px) + m_up * upward(py))};
        case Projection::kOrthographic:
            return {m_position + m_right * across(px) + m_up * upward(py), m_forward};
        case Projection::kPanorama:
            return {m_position, core::normalized(panorama_direction(px, py))};
        case Projection::kFisheye: break;
    }
    return {m_position, core::normalized(fisheye_direction(px, py))};
}

std::optional<core::Ray> Camera::ray(double px, double py, double lens_u,
                                     double lens_v) const noexcept {
    if (!sees(px, py))
        return std::nullopt;
    if (m_lens_radius == 0)
        return ray(px, py);
    const auto [x, y] = concentric_disc(lens_u, lens_v);
    const core::Vec3 on_lens = (m_right * x + m_up * y) * (m_lens_radius / m_half);
    if (m_projection == Projection::kPerspective)
        return core::Ray{
            m_position + on_lens,
            core::normalized((m_forward + m_right * across(px) + m_up * upward(py)) * m_focus -
                             on_lens)};
    return core::Ray{m_position + m_right * across(px) + m_up * upward(py) + on_lens * m_lens_scale,
                     core::normalized(m_forward * m_focus - on_lens)};
}

std::array<double, 2> concentric_disc(double u, double v) noexcept {
    const double a = 2 * u - 1;
    const double b = 2 * v - 1;
    if (a == 0 && b == 0)
        return {0, 0};
    if (a * a > b * b) {
        const double angle = kPi / 4 * (b / a);
        return {a * trig::cos(angle), a * trig::sin(angle)};
    }
    const double angle = kPi / 4 * (a / b);
    return {b * trig::sin(angle), b * trig::cos(angle)};
}

std::array<std::int64_t, 3> Camera::picture_origin() const noexcept {
    const auto whole = [](double v) { return static_cast<std::int64_t>(std::floor(v)); };
    return {whole(m_position.x), whole(m_position.y), whole(m_position.z)};
}

std::array<double, 16> Camera::world_to_camera() const noexcept {
    const auto origin = picture_origin();
    const core::Vec3 eye =
        (m_position - core::Vec3{static_cast<double>(origin[0]), static_cast<double>(origin[1]),
                                 static_cast<double>(origin[2])}) *
        m_voxel_m;
    const core::Vec3 columns[3] = {core::normalized(m_right), core::normalized(m_up), -m_forward};
    std::array<double, 16> m{};
    for (std::size_t column = 0; column < 3; ++column) {
        for (std::size_t row = 0; row < 3; ++row)
            m[row * 4 + column] = columns[column][static_cast<int>(row)];
        m[12 + column] = -core::dot(eye, columns[column]);
    }
    m[15] = 1;
    return m;
}

std::optional<std::array<double, 16>> Camera::world_to_ndc() const noexcept {
    const bool perspective = m_projection == Projection::kPerspective;
    if (!perspective && m_projection != Projection::kOrthographic)
        return std::nullopt;
    const auto camera = world_to_camera();
    const double half_y = core::length(m_up) * (perspective ? 1 : m_voxel_m);
    const double half_x = half_y * m_width / m_height;
    std::array<double, 16> m{};
    for (std::size_t row = 0; row < 4; ++row) {
        const double x = camera[row * 4];
        const double y = camera[row * 4 + 1];
        const double depth = -camera[row * 4 + 2];
        const double one = row == 3 ? 1 : 0;
        const double w = perspective ? depth : one;
        m[row * 4] = x / (2 * half_x) + w / 2;
        m[row * 4 + 1] = -y / (2 * half_y) + w / 2;
        m[row * 4 + 2] = perspective ? one : depth;
        m[row * 4 + 3] = w;
    }
    return m;
}

std::optional<std::array<double, 6>> Camera::geotransform(
    const voxel::WorldInfo& world) const noexcept {
    if (m_projection != Projection::kOrthographic || world.crs.empty() || m_forward.x != 0 ||
        m_forward.z != 0 || m_forward.y > 0)
        return std::nullopt;
    const double unit = world.crs_units_per_voxel;
    const double aspect = m_width / m_height;
    const double step = 2 / m_height;
    return std::array<double, 6>{unit * (m_position.x - m_right.x * aspect + m_up.x),
                                 unit * m_right.x * step,
                                 -unit * m_up.x * step,
                                 -unit * (m_position.z - m_right.z * aspect + m_up.z),
                                 -unit * m_right.z * step,
                                 unit * m_up.z * step};
}

}  // namespace terravox::scene
