#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "common/util/det_math.hpp"
#include "common/voxel/world.hpp"
#include "raytracer/core/base/ray.hpp"
#include "raytracer/core/scene/scene.hpp"

namespace terravox::scene::trig {

/// The only angle functions that cameras and animations use, because their values affect pixels.
[[nodiscard]] inline double sin(double rad) noexcept {
    return det::sin(rad);
}
[[nodiscard]] inline double cos(double rad) noexcept {
    return det::cos(rad);
}
[[nodiscard]] inline double tan(double rad) noexcept {
    return det::tan(rad);
}

inline constexpr double kRadPerDeg = det::kPi / 180;

}  // namespace terravox::scene::trig

namespace terravox::scene {

/// Axes of a picture: unit vectors at right angles.
struct Axes {
    core::Vec3 forward;
    core::Vec3 right;
    core::Vec3 up;
};

/// The axes of a camera that is held upright; if it looks straight down or up, north is up in the
/// picture.
/// @param forward of unit length
[[nodiscard]] Axes make_axes(core::Vec3 forward) noexcept;

/// The axes turned about the line of sight, clockwise as seen from behind the camera; a turn of 0
/// changes no bit.
[[nodiscard]] Axes rolled(const Axes& axes, double roll_deg) noexcept;

/// Tangent of half a field of view.
[[nodiscard]] double half_of_fov(double fov_deg) noexcept;

/// How points in space are projected into the picture. An isometric camera is an orthographic one
/// with a direction of its own.
enum class Projection : std::uint8_t {
    kPerspective,
    kOrthographic,  ///< parallel rays from a plane in front of the world
    /// Equirectangular: the width is a full turn, the middle row the horizon, pixels are square in
    /// angle.
    kPanorama,
    /// Equidistant: the angle to the line of sight is proportional to the distance from the middle.
    kFisheye,
};

/// Parameters of a camera, in level-0 voxels. Nothing is checked here: make_camera() does that.
struct CameraShape {
    Projection projection = Projection::kPerspective;
    core::Vec3 position;
    /// Of unit length, at right angles; of a panorama up is (0, 1, 0).
    core::Vec3 forward{0, 0, -1};
    core::Vec3 right{1, 0, 0};
    core::Vec3 up{0, 1, 0};
    /// Perspective: tangent of half the vertical field of view; orthographic: half of what the
    /// height covers; fisheye: half the field of view, radians.
    double half = 1;
    double lens_radius = 0;  ///< 0: everything is sharp; perspective and orthographic
    double focus = 1;        ///< distance of the sharp plane from the lens, above 0
    /// Orthographic: distance behind the lens of `position`, and with it of the plane that rays
    /// start on.
    double back = 0;
    int width_px = 1;
    int height_px = 1;
    double voxel_m = 1;  ///< edge of a voxel, for results in metres
};

/// Maps picture coordinates to rays, in level-0 voxel coordinates. Immutable, thread-safe.
class Camera {
public:
    /// A perspective camera without a lens: everything is sharp.
    /// @param fov_deg vertical
    Camera(core::Vec3 position, core::Vec3 target, double fov_deg, int width_px, int height_px);
    explicit Camera(const CameraShape& shape);

    /// The ray through picture coordinates and the middle of the lens: px in [0, width], py in [0,
    /// height], y down; direction of unit length. Where sees() is false the ray has a direction,
    /// but it is meaningless.
    [[nodiscard]] core::Ray ray(double px, double py) const noexcept;
    /// The ray through a point of the lens; all rays of a picture point meet on the plane of focus.
    /// @param lens_u, lens_v in [0, 1): uniform numbers give points uniform on the lens
    /// @return nullopt where nothing is seen
    [[nodiscard]] std::optional<core::Ray> ray(double px, double py, double lens_u,
                                               double lens_v) const noexcept;
    /// False outside a fisheye's circle, and above and below the poles of a panorama that is higher
    /// than half its width.
    [[nodiscard]] bool sees(double px, double py) const noexcept;
    /// Whether all rays come from one point and pass through a plane, as described by basis();
    /// beams and packets of primary rays rely on it.
    [[nodiscard]] bool pinhole() const noexcept {
        return m_projection == Projection::kPerspective && m_lens_radius == 0;
    }
    [[nodiscard]] bool has_lens() const noexcept { return m_lens_radius > 0; }

    /// The quantities that ray() of a pinhole uses: the direction is that of (forward + right * u)
    /// + up * v, u = (2 px - width) / height, v = (height - 2 py) / height, times one over its
    /// length.
    struct Basis {
        core::Vec3 position;
        core::Vec3 forward;
        core::Vec3 right;
        core::Vec3 up;
        double width;
        double height;
    };
    [[nodiscard]] Basis basis() const noexcept {
        return {m_position, m_forward, m_right, m_up, m_width, m_height};
    }

    [[nodiscard]] Projection projection() const noexcept { return m_projection; }
    /// Origin of the rays; of an orthographic camera the middle of the plane that they start on.
    [[nodiscard]] core::Vec3 position() const noexcept { return m_position; }
    /// Direction of the middle of the picture, of unit length.
    [[nodiscard]] core::Vec3 forward() const noexcept { return m_forward; }
    /// Angle covered by the pixel in the middle of the picture; 0 for parallel rays.
    [[nodiscard]] double pixel_rad() const noexcept { return m_pixel_rad; }
    /// Width of what a pixel covers at a distance from the ray's start, level-0 voxels.
    [[nodiscard]] double pixel_voxels(double t) const noexcept {
        return m_pixel_voxels + m_pixel_rad * t;
    }
    [[nodiscard]] double voxel_m() const noexcept { return m_voxel_m; }  ///< as in its shape
    /// Half of a fisheye's field of view, radians.
    [[nodiscard]] double half_angle_rad() const noexcept { return m_half; }

    /// The voxel that positions in output for other programs are relative to: close to the camera,
    /// so that single precision suffices.
    [[nodiscard]] std::array<std::int64_t, 3> picture_origin() const noexcept;
    /// Matrices as OpenEXR's worldToCamera and worldToNDC: row-major, points are row vectors (x, y,
    /// z, 1) multiplied from the left. World: metres from the low corner of picture_origin(), x
    /// east, y up, z south. Camera: metres from position(), x right, y up, and the camera looks
    /// down -z (right-handed).
    [[nodiscard]] std::array<double, 16> world_to_camera() const noexcept;
    /// After division by w, x and y are 0, 0 in the picture's upper left corner and 1, 1 in the
    /// lower right one. z only orders by depth: it is 1 / depth in metres for a perspective, the
    /// depth for an orthographic camera.
    /// @return nullopt for panorama and fisheye, which no matrix can describe
    [[nodiscard]] std::optional<std::array<double, 16>> world_to_ndc() const noexcept;
    /// The map coordinates of pixels, in GDAL's order and the world's CRS: easting = g[0] + px g[1]
    /// + py g[2], northing = g[3] + px g[4] + py g[5].
    /// @return nullopt unless the camera is orthographic, looks straight down, and the world has a
    /// CRS
    [[nodiscard]] std::optional<std::array<double, 6>> geotransform(
        const voxel::WorldInfo& world) const noexcept;

private:
    [[nodiscard]] double across(double px) const noexcept { return (2 * px - m_width) / m_height; }
    [[nodiscard]] double upward(double py) const noexcept { return (m_height - 2 * py) / m_height; }
    [[nodiscard]] core::Vec3 panorama_direction(double px, double py) const noexcept;
    [[nodiscard]] core::Vec3 fisheye_direction(double px, double py) const noexcept;

    // Perspective and orthographic: right and up span one picture height / 2.
    core::Vec3 m_position;
    core::Vec3 m_forward;
    core::Vec3 m_right;
    core::Vec3 m_up;
    double m_width;
    double m_height;
    Projection m_projection = Projection::kPerspective;
    // m_lens_scale: of the lens where rays start, seen through the plane of focus.
    double m_half = 0;
    double m_lens_radius = 0;
    double m_focus = 1;
    double m_lens_scale = 1;
    double m_pixel_rad = 0;
    double m_pixel_voxels = 0;
    double m_voxel_m = 1;
};

/// Maps the unit square to the unit disc: equal areas stay equal, neighbours stay neighbours. Ref:
/// Shirley & Chiu, "A Low Distortion Map Between Disk and Square", 1997.
[[nodiscard]] std::array<double, 2> concentric_disc(double u, double v) noexcept;

/// Makes the camera of a scene: with its own position and target, or one that frames `subject`.
/// Orthographic and isometric cameras may have only a target, the middle of the picture; rays start
/// in front of `subject`, and of what stands out of typical heights, whatever the position is. An
/// isometric camera looks from azimuth_deg, wherever it is placed. A panorama uses only the
/// horizontal direction to the target.
/// @param subject level-0 voxels
/// @throws UsageError when position and target coincide, only one is given, a number is out of its
/// range, or the world has no CRS to place them in
[[nodiscard]] Camera make_camera(const Scene& scene, const voxel::WorldInfo& world,
                                 const voxel::VoxelBounds& subject);

/// Converts a point in one of the spaces of Scene::Camera::space to level-0 voxels.
/// @throws UsageError
[[nodiscard]] core::Vec3 to_voxels(const std::array<double, 3>& point, core::CoordinateSpace space,
                                   const voxel::WorldInfo& world);

}  // namespace terravox::scene
