#pragma once

#include "common/voxel/world.hpp"
#include "raytracer/scene/scene.hpp"
#include "raytracer/walk/ray.hpp"

namespace terravox {

/// A perspective camera in level-0 voxel coordinates. Immutable.
class Camera {
public:
    Camera(Vec3 position, Vec3 target, double fov_deg, int width_px, int height_px);

    /// The ray through picture coordinates: px in [0, width), py in [0, height), y down; direction of unit length.
    [[nodiscard]] Ray ray(double px, double py) const noexcept;
    /// What ray() computes with: the direction is that of (forward + right * u) + up * v, u = (2 px - width) / height,
    /// v = (height - 2 py) / height, times one over its length.
    struct Basis {
        Vec3 position, forward, right, up;
        double width, height;
    };
    [[nodiscard]] Basis basis() const noexcept { return {m_position, m_forward, m_right, m_up, m_width, m_height}; }
    [[nodiscard]] Vec3 position() const noexcept { return m_position; }
    /// Angle that the pixel in the middle of the picture covers.
    [[nodiscard]] double pixel_rad() const noexcept { return 2 * length(m_up) / m_height; }
    [[nodiscard]] Vec3 forward() const noexcept { return m_forward; }

private:
    Vec3 m_position, m_forward, m_right, m_up;  // right and up span one picture height / 2
    double m_width, m_height;
};

/// The camera a scene asks for: its own position and target, or one that frames `subject`.
/// @throws UsageError when position and target coincide, only one is given, or the world has no CRS to place them in
[[nodiscard]] Camera make_camera(const Scene& scene, const voxel::WorldInfo& world, const voxel::VoxelBounds& subject);

/// A point in one of the spaces of Scene::Camera::space to level-0 voxels. @throws UsageError
[[nodiscard]] Vec3 to_voxels(const std::array<double, 3>& point, const std::string& space, const voxel::WorldInfo& world);

}  // namespace terravox
