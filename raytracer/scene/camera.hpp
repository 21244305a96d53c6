#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "common/voxel/world.hpp"
#include "raytracer/core/ray.hpp"
#include "raytracer/scene/scene.hpp"

namespace terravox::scene {

/// How space comes into the picture. An isometric camera is an orthographic one that looks down its
/// own way.
enum class Projection : std::uint8_t {
    kPerspective,
    kOrthographic,  ///< parallel rays from a plane before the world
    kPanorama,  ///< equirectangular: the width is once around, the middle row the horizon, pixels
                ///< are square in angle
    kFisheye,   ///< equidistant: the angle to the line of sight grows evenly with the distance from
                ///< the middle
};

/// What a camera is made of, in level-0 voxels. Nothing is checked here: make_camera() does.
struct CameraShape {
    Projection projection = Projection::kPerspective;
    core::Vec3 position;
    core::Vec3 forward{0, 0, -1}, right{1, 0, 0},
        up{0, 1, 0};  ///< of unit length, at right angles; of a panorama up is (0, 1, 0)
    /// perspective: tangent of half the vertical field of view; orthographic: half of what the
    /// height covers; fisheye: half the field of view, radians
    double half = 1;
    double lens_radius = 0;  ///< 0: everything is sharp; perspective and orthographic
    double focus = 1;        ///< distance of the sharp plane from the lens, above 0
    double back = 0;  ///< orthographic: how far behind the lens `position`, and with it the plane
                      ///< that rays start on, lies
    int width_px = 1, height_px = 1;
    double voxel_m = 1;  ///< edge of a voxel, for what is told in metres
};

/// Where the rays of a picture go, in level-0 voxel coordinates. Immutable, thread-safe.
class Camera {
public:
    /// A perspective camera without a lens: everything is sharp. @param fov_deg vertical
    Camera(core::Vec3 position, core::Vec3 target, double fov_deg, int width_px, int height_px);
    explicit Camera(const CameraShape& shape);

    /// The ray through picture coordinates and the middle of the lens: px in [0, width], py in [0,
    /// height], y down; direction of unit length. Where sees() says no it has a direction all the
    /// same, which means nothing.
    [[nodiscard]] core::Ray ray(double px, double py) const noexcept;
    /// Through a point of the lens; all rays of a picture point meet on the plane of focus.
    /// @param lens_u, lens_v in [0, 1): evenly spread, they fill the lens evenly @return nullopt:
    /// nothing is seen there
    [[nodiscard]] std::optional<core::Ray> ray(double px, double py, double lens_u,
                                               double lens_v) const noexcept;
    /// False outside a fisheye's circle, and above and below the poles of a panorama that is higher
    /// than half its width.
    [[nodiscard]] bool sees(double px, double py) const noexcept;
    /// All rays come from one point through a plane, as basis() says: what beams and packets of
    /// primary rays take for granted.
    [[nodiscard]] bool pinhole() const noexcept {
        return m_projection == Projection::kPerspective && m_lens_radius == 0;
    }
    [[nodiscard]] bool has_lens() const noexcept { return m_lens_radius > 0; }

    /// What ray() of a pinhole computes with: the direction is that of (forward + right * u) + up *
    /// v, u = (2 px - width) / height, v = (height - 2 py) / height, times one over its length.
    struct Basis {
        core::Vec3 position, forward, right, up;
        double width, height;
    };
    [[nodiscard]] Basis basis() const noexcept {
        return {m_position, m_forward, m_right, m_up, m_width, m_height};
    }

    [[nodiscard]] Projection projection() const noexcept { return m_projection; }
    /// Where rays come from; of an orthographic camera the middle of the plane that they start on.
    [[nodiscard]] core::Vec3 position() const noexcept { return m_position; }
    /// Where the middle of the picture looks, of unit length.
    [[nodiscard]] core::Vec3 forward() const noexcept { return m_forward; }
    /// Angle that the pixel in the middle of the picture covers; 0 for parallel rays.
    [[nodiscard]] double pixel_rad() const noexcept { return m_pixel_rad; }
    /// What a pixel covers at a distance from where its ray starts, level-0 voxels across.
    [[nodiscard]] double pixel_voxels(double t) const noexcept {
        return m_pixel_voxels + m_pixel_rad * t;
    }
    [[nodiscard]] double voxel_m() const noexcept { return m_voxel_m; }  ///< as in its shape
    /// Half of a fisheye's field of view, radians.
    [[nodiscard]] double half_angle_rad() const noexcept { return m_half; }

    /// The voxel that positions told to other programs count from: close to the camera, so that
    /// single precision suffices.
    [[nodiscard]] std::array<std::int64_t, 3> picture_origin() const noexcept;
    /// Matrices as OpenEXR's worldToCamera and worldToNDC: row-major, points are row vectors (x, y,
    /// z, 1) multiplied from the left. World: metres from the low corner of picture_origin(), x
    /// east, y up, z south. Camera: metres from position(), x right, y up, and the camera looks
    /// down -z (right-handed).
    [[nodiscard]] std::array<double, 16> world_to_camera() const noexcept;
    /// After division by w, x and y are 0, 0 in the picture's upper left corner and 1, 1 in the
    /// lower right one. z only tells nearer from farther: 1 / depth in metres for a perspective,
    /// the depth for an orthographic camera.
    /// @return nullopt for panorama and fisheye, which no matrix describes
    [[nodiscard]] std::optional<std::array<double, 16>> world_to_ndc() const noexcept;
    /// Where pixels lie on the map, in GDAL's order and the world's CRS: easting = g[0] + px g[1] +
    /// py g[2], northing = g[3] + px g[4] + py g[5].
    /// @return nullopt unless the camera is orthographic, looks straight down, and the world has a
    /// CRS
    [[nodiscard]] std::optional<std::array<double, 6>> geotransform(
        const voxel::WorldInfo& world) const noexcept;

private:
    [[nodiscard]] double across(double px) const noexcept { return (2 * px - m_width) / m_height; }
    [[nodiscard]] double upward(double py) const noexcept { return (m_height - 2 * py) / m_height; }
    [[nodiscard]] core::Vec3 panorama_direction(double px, double py) const noexcept;
    [[nodiscard]] core::Vec3 fisheye_direction(double px, double py) const noexcept;

    core::Vec3 m_position, m_forward, m_right,
        m_up;  // perspective and orthographic: right and up span one picture height / 2
    double m_width, m_height;
    Projection m_projection = Projection::kPerspective;
    double m_half = 0, m_lens_radius = 0, m_focus = 1,
           m_lens_scale =
               1;  // m_lens_scale: of the lens where rays start, seen through the plane of focus
    double m_pixel_rad = 0, m_pixel_voxels = 0, m_voxel_m = 1;
};

/// The point of the unit disc for a point of the unit square: equal areas stay equal, neighbours
/// stay neighbours. Ref: Shirley & Chiu, "A Low Distortion Map Between Disk and Square", 1997.
[[nodiscard]] std::array<double, 2> concentric_disc(double u, double v) noexcept;

/// The camera a scene asks for: its own position and target, or one that frames `subject`.
/// Orthographic and isometric cameras may have a target alone, the middle of the picture; rays
/// start before `subject` whatever the position is. An isometric camera looks from azimuth_deg,
/// wherever it is placed. A panorama takes only its direction on the map from the target.
/// @param subject level-0 voxels
/// @throws UsageError when position and target coincide, only one is given, a number is out of its
/// range, or the world has no CRS to place them in
[[nodiscard]] Camera make_camera(const Scene& scene, const voxel::WorldInfo& world,
                                 const voxel::VoxelBounds& subject);

/// A point in one of the spaces of Scene::Camera::space to level-0 voxels. @throws UsageError
[[nodiscard]] core::Vec3 to_voxels(const std::array<double, 3>& point, core::CoordinateSpace space,
                                   const voxel::WorldInfo& world);

}  // namespace terravox::scene
