#include <cmath>

#include "raytracer/core/scene/camera.hpp"

namespace terravox::scene {

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
