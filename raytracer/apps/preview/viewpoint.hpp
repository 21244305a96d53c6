#pragma once

#include "raytracer/core/scene/camera.hpp"
#include "raytracer/core/scene/scene.hpp"

namespace terravox::preview {

/// Where a person stands in a world, and the point that they look at: what mouse and keys
/// move. Level-0 voxels.
struct Viewpoint {
    core::Vec3 position;
    core::Vec3 target;

    /// The viewpoint of a camera; its target is where the middle ray meets the height `ground_y`.
    [[nodiscard]] static Viewpoint of(const scene::Camera& camera, double ground_y);
    /// Writes the viewpoint into the fields of a scene: in the world's CRS, in voxels where it has
    /// none, rounded to millimetres.
    void apply(scene::Scene& scene, const voxel::WorldInfo& world) const;

    [[nodiscard]] double distance() const noexcept { return core::length(target - position); }
    [[nodiscard]] double heading_deg()
        const noexcept;  ///< azimuth of the line of sight, clockwise from north, [0, 360)
    [[nodiscard]] double down_deg()
        const noexcept;  ///< angle of the line of sight below the horizon, [-90, 90]

    /// Orbits the target to the right and up, never over the top.
    void orbit(double right_deg, double up_deg) noexcept {
        set_direction(heading_deg() - right_deg, down_deg() + up_deg, true);
    }
    /// Turns the line of sight to the right and down.
    void look(double right_deg, double down_deg) noexcept;
    /// Moves along the ground, relative to the heading, and upwards, voxels.
    void walk(double right, double up, double forward) noexcept;
    /// Moves along the line of sight and across it, voxels.
    void fly(double right, double up, double forward) noexcept;
    /// Moves towards the target, which stays.
    /// @param factor of the distance
    void approach(double factor) noexcept;
    /// Moves the target there, and the position with it.
    void go_to(core::Vec3 point) noexcept;
    /// Turns towards the point, which becomes the target; the position stays.
    void face(core::Vec3 point) noexcept;

    /// Limits of the distance to the target, voxels.
    static constexpr double kNearest = 2;
    static constexpr double kFarthest = 1e6;
    friend bool operator==(const Viewpoint&, const Viewpoint&) = default;

private:
    void set_direction(double heading_deg, double down_deg, bool target_stays) noexcept;
};

/// Where a camera shows a point, pixels from the upper left corner.
/// @return nullopt behind the camera, and for panoramas and fisheyes
[[nodiscard]] std::optional<std::array<double, 2>> find_pixel(const scene::Camera& camera,
                                                              core::Vec3 point, int width_px,
                                                              int height_px) noexcept;

}  // namespace terravox::preview
