#include "raytracer/core/scene/camera.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "raytracer/core/scene/camera_axes.hpp"
#include "raytracer/core/scene/trig.hpp"

namespace terravox::scene {

constexpr double kPi = std::numbers::pi;

Axes axes_of(core::Vec3 forward) noexcept {
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
          const Axes axes = axes_of(core::normalized(target - position));
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

}  // namespace terravox::scene
